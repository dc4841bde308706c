#include "furrow/altitude/fuse.h"

#include <algorithm>
#include <cmath>

#include "furrow/base/text.h"
#include "fusion_results.h"

namespace furrow::altitude {
namespace {

Status check_input(const std::vector<HeightSample>& samples, const FusionSetup& setup) {
  const FuseOptions& options = setup.options;
  if (samples.empty()) return Error{"no_samples", "fuse", "no samples", "one sample or more", ""};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool sound = std::isfinite(samples[i].t_s) && (i == 0 || samples[i].t_s > samples[i - 1].t_s);
    if (!sound) {
      return Error{"times_not_increasing", "sample " + std::to_string(i + 1),
                   base::format_double(samples[i].t_s) + " s", "a finite time after the one before", ""};
    }
  }
  for (const double sigma : {options.acceleration_sigma, options.baro_sigma_m, options.vps_sigma_m,
                             options.gnss_sigma_m, options.depth_bias_sigma_m, options.gate_sigmas}) {
    if (!(std::isfinite(sigma) && sigma > 0.0)) {
      return Error{"not_finite", "fuse options", base::format_double(sigma), "finite sigmas above 0", ""};
    }
  }
  if (any_absolute(samples, setup)) return Done{};
  if (!any(samples, HeightSource::vps, setup)) {
    return Error{"no_absolute_height", "fuse", "only barometer or GNSS, whose zero is not known",
                 "vision, depth or a downward sensor", ""};
  }
  if (options.row_height_m.usable()) return Done{};
  return Error{"no_row_height", "fuse", "a downward sensor alone, and no height of the rows",
               "the rows' height", ""};
}

/// Every cause that some picture shares, once.
std::vector<std::string> causes_of(const std::vector<HeightSample>& samples) {
  std::vector<std::string> causes;
  const auto add = [&causes](const std::vector<SigmaShare>& shares) {
    for (const SigmaShare& share : shares) {
      if (std::find(causes.begin(), causes.end(), share.cause) == causes.end()) causes.push_back(share.cause);
    }
  };
  for (const HeightSample& sample : samples) {
    add(sample.vision_shared);
    add(sample.depth_shared);
  }
  return causes;
}

}  // namespace

std::string source_name(HeightSource source) {
  static const char* const kNames[kHeightSources] = {"vision", "depth", "baro", "vps", "gnss"};
  return kNames[place(source)];
}

Result<FusedFlight> fuse(const std::vector<HeightSample>& samples, const FuseOptions& options) {
  const FusionSetup setup{options, causes_of(samples)};
  FURROW_DO(check_input(samples, setup));
  return describe(samples, settle(samples, setup));
}

}  // namespace furrow::altitude
