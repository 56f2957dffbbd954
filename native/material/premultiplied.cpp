// SPDX-License-Identifier: GPL-3.0-or-later
#include "material/premultiplied.h"

#include <limits>
#include <vector>

namespace penumbra {
namespace {

namespace io = OIIO;
constexpr const char* kUnassociated = "oiio:UnassociatedAlpha";

/// Whole numbers are rounded down, as in Cycles.
template <class Value, class Product>
void multiply(Value* values, size_t pixels, int channels, int alpha) {
  for (Value* pixel = values; pixel != values + pixels * size_t(channels); pixel += channels)
    for (int c = 0; c < channels; ++c) {
      if (c == alpha) continue;
      const Product product = Product(pixel[c]) * Product(pixel[alpha]);
      if constexpr (std::numeric_limits<Value>::is_integer)
        pixel[c] = Value(product / std::numeric_limits<Value>::max());
      else
        pixel[c] = Value(product);
    }
}

}  // namespace

bool Premultiplied::open(const std::string& name, io::ImageSpec& spec, const io::ImageSpec& configuration) {
  io::ImageSpec raw = configuration;
  raw.attribute(kUnassociated, 1);
  file_ = io::ImageInput::open(name, &raw);
  if (!file_) {
    errorfmt("{}", io::geterror());
    return false;
  }
  take_spec();
  spec = m_spec;
  return true;
}

bool Premultiplied::close() {
  const bool closed = !file_ || file_->close();
  file_.reset();
  return closed;
}

bool Premultiplied::seek_subimage(int subimage, int miplevel) {
  if (!file_ || !checked(file_->seek_subimage(subimage, miplevel))) return false;
  take_spec();
  return true;
}

bool Premultiplied::read_native_scanline(int subimage, int miplevel, int y, int z, void* data) {
  if (!seek_subimage(subimage, miplevel) ||
      !checked(file_->read_native_scanline(subimage, miplevel, y, z, data)))
    return false;
  multiply(data, size_t(m_spec.width));
  return true;
}

bool Premultiplied::read_native_tile(int subimage, int miplevel, int x, int y, int z, void* data) {
  if (!seek_subimage(subimage, miplevel) ||
      !checked(file_->read_native_tile(subimage, miplevel, x, y, z, data)))
    return false;
  multiply(data, size_t(m_spec.tile_pixels()));
  return true;
}

void Premultiplied::take_spec() {
  m_spec = file_->spec();
  multiplies_ = m_spec.alpha_channel >= 0 && m_spec.get_int_attribute(kUnassociated) != 0;
  m_spec.erase_attribute(kUnassociated);
}

bool Premultiplied::checked(bool succeeded) {
  if (!succeeded && file_->has_error()) errorfmt("{}", file_->geterror());
  return succeeded;
}

void Premultiplied::multiply(void* data, size_t pixels) const {
  if (!multiplies_) return;
  const int channels = m_spec.nchannels, alpha = m_spec.alpha_channel;
  if (m_spec.format == io::TypeDesc::UINT8)
    penumbra::multiply<uint8_t, uint32_t>(static_cast<uint8_t*>(data), pixels, channels, alpha);
  else if (m_spec.format == io::TypeDesc::UINT16)
    penumbra::multiply<uint16_t, uint64_t>(static_cast<uint16_t*>(data), pixels, channels, alpha);
  else {
    std::vector<float> values(pixels * size_t(channels));
    io::convert_pixel_values(m_spec.format, data, io::TypeDesc::FLOAT, values.data(), int(values.size()));
    penumbra::multiply<float, float>(values.data(), pixels, channels, alpha);
    io::convert_pixel_values(io::TypeDesc::FLOAT, values.data(), m_spec.format, data, int(values.size()));
  }
}

}  // namespace penumbra
