// SPDX-License-Identifier: GPL-3.0-or-later
#include "material/textures.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/texture.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>

#include "material/colour_spaces.h"
#include "material/premultiplied.h"

namespace penumbra {
namespace {

namespace io = OIIO;

/// What no honest texture exceeds: pixels a side, channels, and bytes when decoded, of all or of one tile.
constexpr int kMaxSide = 65536, kMaxChannels = 64;
constexpr uint64_t kMaxBytes = uint64_t(8) << 30;
constexpr float kCacheMegabytes = 2048;
/// Memory that a file's pixels take while they are decoded (measured: 1.2 to 2.02 times their size), and what
/// else a render wants meanwhile (measured: 160 MiB).
constexpr uint64_t kDecoding = 2, kElse = uint64_t(256) << 20;

/// Files that are not tiled are decoded as a whole: half of the machine's memory at most.
uint64_t most_bytes() {
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
  return pages > 0 && page > 0 ? std::min(kMaxBytes, uint64_t(pages) * uint64_t(page) / 2) : kMaxBytes;
}

/// The texture system and its cache, ours alone; OpenImageIO 3 hands out shared pointers, 2 plain ones.
class System {
 public:
  /// raw: colours as they are in the file, not multiplied by the fourth channel.
  explicit System(bool raw)
      : cache_(io::ImageCache::create(false)), textures_(io::TextureSystem::create(false, cache_)) {
    cache_->attribute("max_memory_MB", kCacheMegabytes);
    cache_->attribute("unassociatedalpha", raw ? 1 : 0);
  }
  System(const System&) = delete;
  System& operator=(const System&) = delete;
  ~System() {
    // OpenImageIO 2 deletes its 184 bytes as one, which ruins jemalloc's heap: it is left.
    if (OIIO_VERSION >= 30000) io::TextureSystem::destroy(textures_);
    io::ImageCache::destroy(cache_);
  }

  io::ImageCache& images() const { return *cache_; }
  io::TextureSystem& textures() const { return *textures_; }

 private:
  decltype(io::ImageCache::create(false)) cache_;
  decltype(io::TextureSystem::create(false)) textures_;
};

struct Tile {
  uint32_t number = 0;
  io::TextureSystem::TextureHandle* handle = nullptr;
  int channels = 0;
};

struct Entry {
  const Image* image;
  const System* system = nullptr;
  std::vector<Tile> tiles;
  std::string problem;                      // found when it was opened
  mutable std::atomic<bool> failed{false};  // in a lookup
};

/// Does a limit of the process forbid so much memory? It is not touched.
bool can_get(uint64_t bytes) {
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return false;
  munmap(memory, bytes);
  return true;
}

std::string refusal(const io::ImageSpec& spec) {
  if (spec.width > kMaxSide || spec.height > kMaxSide || spec.nchannels > kMaxChannels || spec.depth > 1)
    return "it has " + std::to_string(spec.width) + " x " + std::to_string(spec.height) + " x " +
           std::to_string(spec.depth) + " pixels of " + std::to_string(spec.nchannels) +
           " channels, more than are read";
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) return "it has no pixels";
  const uint64_t bytes = std::max(spec.image_bytes(), spec.tile_bytes()), most = most_bytes();
  if (bytes > most)
    return "it would need " + std::to_string(bytes >> 20) + " MiB, and no more than " +
           std::to_string(most >> 20) + " MiB are read";
  // OpenImageIO 2.4 does not survive it if there is no memory left.
  if (const uint64_t needed = kDecoding * bytes + kElse; !can_get(needed))
    return "this process cannot get the " + std::to_string(needed >> 20) + " MiB that decoding it may take";
  return {};
}

io::TextureOpt options(const Image& image) {
  constexpr int kWraps[] = {3, 4, 2, 1};  // periodic, mirror, clamp, black
  io::TextureOpt result;
  result.swrap = result.twrap = static_cast<decltype(result.swrap)>(kWraps[int(image.wrap)]);
  result.mipmode = static_cast<decltype(result.mipmode)>(1);  // none: Cycles uses the full resolution, too
  constexpr int kModes[] = {1, 0, 2};                         // bilinear, closest, bicubic
  result.interpmode = static_cast<decltype(result.interpmode)>(kModes[int(image.interpolation)]);
  return result;
}

Vec3f linear(const Vec3f& c) {
  return {linear_from_srgb(c.x), linear_from_srgb(c.y), linear_from_srgb(c.z)};
}

}  // namespace

struct Textures::State {
  std::vector<Image> images;
  std::vector<std::unique_ptr<io::Filesystem::IOMemReader>> readers;
  std::vector<Entry> entries;
  std::unique_ptr<System> associated, raw;  // go first: they read from the readers

  System& system_of(const Image& image) {
    std::unique_ptr<System>& system = image.is_raw() ? raw : associated;
    if (!system) system = std::make_unique<System>(image.is_raw());
    return *system;
  }
  explicit State(const std::vector<Image>& all) : images(all), entries(all.size()) {}
  void open(Entry& entry);
  std::string open(Entry& entry, const ImageFile& file, size_t number);
};

/// Opens one file and reads its header; the problem, if there is one.
std::string Textures::State::open(Entry& entry, const ImageFile& file, size_t number) {
  entry.system = &system_of(*entry.image);
  const System& system = *entry.system;
  io::ustring name(file.path);
  const io::ImageInput::Creator reader = entry.image->is_raw() ? nullptr : Premultiplied::create;
  io::ImageSpec configuration;
  if (file.bytes) {
    // The texture system knows files by their names; that of a packed one keeps its suffix.
    name = io::ustring("packed-" + std::to_string(&entry - entries.data()) + "-" + std::to_string(number) +
                       "-" + io::Filesystem::filename(file.path));
    readers.push_back(std::make_unique<io::Filesystem::IOMemReader>(file.bytes->data(), file.bytes->size()));
    io::Filesystem::IOProxy* proxy = readers.back().get();
    configuration.attribute("oiio:ioproxy", io::TypeDesc::PTR, &proxy);
    if (entry.image->is_raw()) configuration.attribute("oiio:UnassociatedAlpha", 1);
    if (!system.images().add_file(name, reader, &configuration)) return system.images().geterror();
  } else if (!io::Filesystem::is_regular(file.path)) {
    return "there is no such file: " + file.path;
  } else if (reader && !system.images().add_file(name, reader, nullptr)) {
    return system.images().geterror();
  }
  io::ImageSpec spec;
  if (!system.images().get_imagespec(name, spec)) {
    const std::string error = system.images().geterror();
    return error.empty() ? "it cannot be read" : error;
  }
  if (std::string reason = refusal(spec); !reason.empty()) return reason;
  auto* handle = system.textures().get_texture_handle(name);
  if (!handle || !system.textures().good(handle)) return "it cannot be read";
  entry.tiles.push_back({file.tile, handle, std::min(spec.nchannels, 4)});
  return {};
}

void Textures::State::open(Entry& entry) {
  for (size_t i = 0; i < entry.image->files.size(); ++i) {
    std::string problem;
    try {
      problem = open(entry, entry.image->files[i], i);
    } catch (const std::exception& error) {
      problem = error.what();
    }
    if (entry.problem.empty()) entry.problem = problem;
  }
}

Textures::Textures(const std::vector<Image>& images) : state_(std::make_unique<State>(images)) {
  for (size_t i = 0; i < images.size(); ++i) {
    state_->entries[i].image = &state_->images[i];
    state_->open(state_->entries[i]);
  }
}

Textures::~Textures() = default;

Texel Textures::lookup(uint32_t number, float u, float v) const {
  const Entry& entry = state_->entries[number];
  const Image& image = *entry.image;
  if (!std::isfinite(u) || !std::isfinite(v)) return {{0, 0, 0}, 0};
  uint32_t wanted = 1001;
  if (image.tiled) {
    const float column = std::floor(u), row = std::floor(v);
    if (column < 0 || column > 9 || row < 0 || row > 99) return Texel::missing();
    wanted += uint32_t(column) + 10 * uint32_t(row);
    u -= column;
    v -= row;
  }
  const auto tile = std::find_if(entry.tiles.begin(), entry.tiles.end(),
                                 [&](const Tile& t) { return !image.tiled || t.number == wanted; });
  if (tile == entry.tiles.end()) return Texel::missing();

  io::TextureOpt how = options(image);
  float c[4] = {0, 0, 0, 1};
  bool read = false;
  try {
    read =
        entry.system->textures().texture(tile->handle, nullptr, how, u, 1 - v, 0, 0, 0, 0, tile->channels, c);
  } catch (const std::exception&) {  // no memory for its pixels: as if they could not be read
  }
  if (!read) {
    if (!entry.failed.exchange(true)) return Texel::missing();
    entry.system->textures().geterror();  // the first one was enough
    return Texel::missing();
  }
  Texel texel;
  texel.colour = tile->channels < 3 ? Vec3f{c[0], c[0], c[0]} : Vec3f{c[0], c[1], c[2]};
  texel.alpha = tile->channels == 2 ? c[1] : c[3];
  if (image.alpha == ImageAlpha::kNone) texel.alpha = 1;
  // As Cycles does it: before the values are made linear.
  if (image.alpha == ImageAlpha::kStraight && texel.alpha > 0) texel.colour = texel.colour / texel.alpha;
  if (image.srgb) texel.colour = linear(texel.colour);
  return texel;
}

std::vector<std::string> Textures::problems() const {
  std::vector<std::string> result;
  for (const Entry& entry : state_->entries) {
    if (entry.problem.empty() && !entry.failed) continue;
    const std::string reason = entry.problem.empty() ? "parts of it cannot be read" : entry.problem;
    result.push_back(entry.image->name + ": " + reason + "; rendered in magenta");
  }
  return result;
}

std::string encode_image(uint32_t width, uint32_t height, uint32_t channels, const float* pixels) {
  const auto output = io::ImageOutput::create("pixels.exr");
  std::vector<unsigned char> bytes;
  io::Filesystem::IOVecOutput proxy(bytes);
  io::ImageSpec spec(int(width), int(height), int(channels), io::TypeDesc::FLOAT);
  spec.attribute("compression", "none");
  const auto row = io::stride_t(width) * channels * io::stride_t(sizeof(float));
  if (!output || !output->set_ioproxy(&proxy) || !output->open("pixels.exr", spec) ||
      !output->write_image(io::TypeDesc::FLOAT, pixels + (height - 1) * row / io::stride_t(sizeof(float)),
                           io::AutoStride, -row) ||
      !output->close())
    throw std::runtime_error("pixels cannot be encoded: " + (output ? output->geterror() : io::geterror()));
  return {bytes.begin(), bytes.end()};
}

}  // namespace penumbra
