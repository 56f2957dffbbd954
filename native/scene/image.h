// SPDX-License-Identifier: GPL-3.0-or-later
// Images that materials look up, as the export describes them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace penumbra {

enum class ImageWrap : uint8_t { kRepeat, kMirror, kExtend, kClip };
enum class ImageInterpolation : uint8_t { kLinear, kClosest, kCubic };

/// What an image's fourth channel is.
enum class ImageAlpha : uint8_t {
  kCoverage,  // in the colours, as OpenImageIO makes them: premultiplied
  kStraight,  // coverage that is taken out of the colours again
  kChannel,   // a channel like the others
  kNone       // ignored: 1
};

/// Where the pixels of one tile are: a file, or the bytes of one (of which `path` is then the name alone).
struct ImageFile {
  uint32_t tile = 1001;  // UDIM number
  std::string path;
  std::shared_ptr<const std::string> bytes;
};

struct Image {
  std::string name;  // for messages: the image, the material and the node
  std::vector<ImageFile> files;
  bool tiled = false;  // UDIM: the whole part of the coordinates chooses the tile
  ImageWrap wrap = ImageWrap::kRepeat;
  ImageInterpolation interpolation = ImageInterpolation::kLinear;
  bool srgb = false;  // values follow sRGB's curve; interpolated as they are, then made linear, as in Cycles
  ImageAlpha alpha = ImageAlpha::kCoverage;

  bool is_raw() const { return alpha == ImageAlpha::kChannel || alpha == ImageAlpha::kNone; }
};

}  // namespace penumbra
