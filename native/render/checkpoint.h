// SPDX-License-Identifier: GPL-3.0-or-later
// Finished buckets on disk, so that a render that was killed can go on where it stopped.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "render/block.h"

namespace penumbra {

/// A folder with one file a bucket, each written under another name first and then renamed: it is whole or
/// not there. The file `render.txt` says what it is a checkpoint of.
class Checkpoint {
 public:
  /// What must be the same for a checkpoint to go on: names and values.
  using Identity = std::vector<std::pair<std::string, std::string>>;

  /// Makes the folder where there is none. Throws std::invalid_argument with a sentence if it holds another
  /// render's checkpoint or something else, std::runtime_error if it cannot be written to.
  Checkpoint(const std::string& folder, const Identity& identity);

  /// Reads a bucket into the film and its counts into the tally. False if it was not finished, or its file is
  /// damaged: then it has to be rendered.
  bool load(const Rectangle& bucket, Film& film, RenderTally& tally) const;

  /// Writes a finished bucket; std::runtime_error naming the file if that fails. Threads may write different
  /// buckets at the same time.
  void save(const Rectangle& bucket, const Film& film, const RenderTally& tally) const;

 private:
  std::filesystem::path path_of(const Rectangle& bucket) const;

  std::filesystem::path folder_;
};

}  // namespace penumbra
