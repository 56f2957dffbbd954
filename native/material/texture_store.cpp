// SPDX-License-Identifier: GPL-3.0-or-later
#include "material/texture_store.h"

#include <filesystem>

#include "sampling/hash.h"

namespace penumbra {
namespace {

uint64_t fingerprint_of(const std::vector<Image>& images) {
  uint64_t h = images.size();
  const auto include = [&](const std::string& text) { h = hash_bytes(h, text.data(), text.size()); };
  for (const Image& image : images) {
    include(image.name);
    h = hash_of(h, uint64_t(image.tiled), uint64_t(image.wrap), uint64_t(image.interpolation),
                uint64_t(image.srgb), uint64_t(image.alpha));
    for (const ImageFile& file : image.files) {
      h = hash_of(h, file.tile);
      include(file.path);
      if (file.bytes) {
        include(*file.bytes);
      } else {
        std::error_code error;
        const auto changed = std::filesystem::last_write_time(file.path, error);
        h = hash_of(h, error ? 0 : uint64_t(changed.time_since_epoch().count()));
      }
    }
  }
  return h;
}

}  // namespace

std::shared_ptr<const Textures> TextureStore::textures_of(const std::vector<Image>& images) {
  const uint64_t fingerprint = fingerprint_of(images);
  if (!last_ || fingerprint != fingerprint_) {
    last_.reset();
    last_ = std::make_shared<const Textures>(images);
    fingerprint_ = fingerprint;
  }
  return last_;
}

}  // namespace penumbra
