// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/checkpoint.h"

#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "sampling/hash.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDescription = "render.txt";
constexpr const char* kFirstLine = "Penumbra checkpoint 1";

/// Whole file at once: to a temporary name, then to its own.
void write_file(const fs::path& path, const std::string& content) {
  const fs::path temporary = path.string() + ".tmp";
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write(content.data(), std::streamsize(content.size()));
  file.close();
  std::error_code error;
  if (file) fs::rename(temporary, path, error);
  if (!file || error) throw std::runtime_error("checkpoint: cannot write " + path.string());
}

/// Empty if it cannot be read.
std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string as_line(const std::pair<std::string, std::string>& entry) {
  return entry.first + ": " + entry.second;
}

template <typename T>
void append(std::string& out, const T* values, size_t count) {
  out.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

uint64_t hash_of_text(const char* data, size_t size) {
  return hash_bytes(size, data, size);
}

}  // namespace

Checkpoint::Checkpoint(const std::string& folder, const Identity& identity) : folder_(folder) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error || !fs::is_directory(folder_))
    throw std::runtime_error("checkpoint: the folder " + folder + " cannot be made");
  std::string text = std::string(kFirstLine) + "\n";
  for (const auto& entry : identity) text += as_line(entry) + "\n";

  const fs::path path = folder_ / kDescription;
  const std::string found = read_file(path);
  if (found == text) return;
  if (found.empty()) {
    if (!fs::is_empty(folder_) && !fs::exists(path.string() + ".tmp"))
      throw std::invalid_argument("checkpoint: the folder " + folder + " holds other files");
    write_file(path, text);
    return;
  }
  std::string reason = "it is not this version's";
  for (const auto& entry : identity)
    if (found.find(as_line(entry) + "\n") == std::string::npos) {
      reason = "it is of another " + entry.first + " than " + entry.second;
      break;
    }
  throw std::invalid_argument("checkpoint: " + folder + " cannot be continued: " + reason +
                              ". Remove it or choose another folder");
}

fs::path Checkpoint::path_of(const Rectangle& bucket) const {
  return folder_ / ("bucket_" + std::to_string(bucket.x) + "_" + std::to_string(bucket.y) + ".bin");
}

void Checkpoint::save(const Rectangle& bucket, const Film& film, const RenderTally& tally) const {
  std::string content;
  append(content, &bucket, 1);
  const RenderTally::Counts counts = tally.counts();
  append(content, counts.data(), counts.size());
  const std::vector<float> pixels = film.copy(bucket);
  append(content, pixels.data(), pixels.size());
  content += tally.first_non_finite;
  const uint64_t sum = hash_of_text(content.data(), content.size());
  append(content, &sum, 1);
  write_file(path_of(bucket), content);
}

bool Checkpoint::load(const Rectangle& bucket, Film& film, RenderTally& tally) const {
  const std::string content = read_file(path_of(bucket));
  RenderTally::Counts counts;
  std::vector<float> pixels(film.copy(bucket).size());
  uint64_t sum;
  const size_t pixel_bytes = pixels.size() * sizeof(float);
  const size_t text_begin = sizeof(bucket) + sizeof(counts) + pixel_bytes;
  if (content.size() < text_begin + sizeof(sum)) return false;
  const size_t text_end = content.size() - sizeof(sum);
  std::memcpy(&sum, content.data() + text_end, sizeof(sum));
  if (sum != hash_of_text(content.data(), text_end) ||
      std::memcmp(content.data(), &bucket, sizeof(bucket)) != 0)
    return false;
  std::memcpy(counts.data(), content.data() + sizeof(bucket), sizeof(counts));
  if (!pixels.empty())
    std::memcpy(pixels.data(), content.data() + sizeof(bucket) + sizeof(counts), pixel_bytes);
  film.paste(bucket, pixels);
  tally = RenderTally(counts, content.substr(text_begin, text_end - text_begin));
  return true;
}

}  // namespace penumbra
