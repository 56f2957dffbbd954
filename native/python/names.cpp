// SPDX-License-Identifier: GPL-3.0-or-later
// Enumerations by the names of the add-on's settings.
#include <utility>
#include <vector>

#include "python/bindings.h"

namespace penumbra::python {
namespace {

template <typename T>
using Names = std::vector<std::pair<const char*, T>>;

template <typename T>
T from_name(const char* setting, const std::string& name, const Names<T>& names) {
  std::string allowed;
  for (const auto& [text, value] : names) {
    if (name == text) return value;
    allowed += (allowed.empty() ? "" : ", ") + std::string(text);
  }
  throw pybind11::value_error(std::string(setting) + " is '" + name + "', expected one of " + allowed);
}

}  // namespace

SamplerKind sampler_from_name(const std::string& name) {
  return from_name<SamplerKind>("sampler", name,
                                {{"PRS", SamplerKind::kPrs},
                                 {"SPRS", SamplerKind::kSprs},
                                 {"SOBOL", SamplerKind::kSobol},
                                 {"HALTON", SamplerKind::kHalton},
                                 {"OWEN_SOBOL", SamplerKind::kOwenSobol}});
}

SampleReuse reuse_from_name(const std::string& name) {
  return from_name<SampleReuse>("sample_reuse", name,
                                {{"SAME", SampleReuse::kSame},
                                 {"CONTINUED", SampleReuse::kContinued},
                                 {"ROTATED", SampleReuse::kRotated},
                                 {"SCRAMBLED", SampleReuse::kScrambled}});
}

StopRuleKind stop_rule_from_name(const std::string& name) {
  return from_name<StopRuleKind>("stop_rule", name,
                                 {{"FIXED", StopRuleKind::kFixed},
                                  {"PAPER", StopRuleKind::kPaper},
                                  {"VARIANCE", StopRuleKind::kVariance},
                                  {"BOUNDED", StopRuleKind::kBounded}});
}

FilterKind filter_from_name(const std::string& name) {
  return from_name<FilterKind>("filter_type", name,
                               {{"BOX", FilterKind::kBox}, {"BLACKMAN_HARRIS", FilterKind::kBlackmanHarris}});
}

}  // namespace penumbra::python
