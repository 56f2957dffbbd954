// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <OpenImageIO/imageio.h>

namespace penumbra {

/// Reads a file of any format with its colours multiplied by its coverage. Some of OpenImageIO's own readers
/// do that in linear light since 2.5 (PNG); here, as in Cycles, the file's own numbers are multiplied,
/// whatever the version.
class Premultiplied final : public OIIO::ImageInput {
 public:
  /// For ImageCache::add_file.
  static OIIO::ImageInput* create() { return new Premultiplied; }

  const char* format_name() const override { return "premultiplied"; }
  int supports(OIIO::string_view feature) const override { return feature == "ioproxy"; }
  bool open(const std::string& name, OIIO::ImageSpec& spec) override { return open(name, spec, {}); }
  bool open(const std::string& name, OIIO::ImageSpec& spec, const OIIO::ImageSpec& configuration) override;
  bool close() override;
  int current_subimage() const override { return file_ ? file_->current_subimage() : 0; }
  int current_miplevel() const override { return file_ ? file_->current_miplevel() : 0; }
  bool seek_subimage(int subimage, int miplevel) override;
  bool read_native_scanline(int subimage, int miplevel, int y, int z, void* data) override;
  bool read_native_tile(int subimage, int miplevel, int x, int y, int z, void* data) override;

 private:
  /// What the file says of the part that is read now.
  void take_spec();
  /// Passes a failure of the file on as ours.
  bool checked(bool succeeded);
  void multiply(void* data, size_t pixels) const;

  std::unique_ptr<OIIO::ImageInput> file_;
  bool multiplies_ = false;
};

}  // namespace penumbra
