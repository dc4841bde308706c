#pragma once
#include <vector>

#include "furrow/audit/fusion.h"
#include "furrow/figures/figures.h"

namespace furrow::figures {

/// Heights of the log alone over the shots: above take-off (IMU and barometer), and above the surface below
/// (VPS) beside it with `vps` (thesis, figures of section 7). Errors: nothing_to_draw (no log height).
Result<Figure> log_heights_over_shots(const std::vector<audit::ShotRecord>& records, bool vps,
                                      const FigureOptions& options = {});

/// Fused height above the canopy with its sigma band over the shots, and each source with its bias taken off;
/// readings that were left out are crosses. Errors: nothing_to_draw (no sample).
Result<Figure> fusion_over_shots(const std::vector<audit::ShotRecord>& records,
                                 const audit::FlightFusion& fusion, const FigureOptions& options = {});

}  // namespace furrow::figures
