#pragma once
#include <vector>

#include "furrow/calib/calibrate.h"

/// Prints claimed over sampled standard deviation of fx, cx and of the projection at nine image points, at
/// the boards' distance and at infinity, of 200 solves of the set's own exact corners with fresh noise of its
/// own level.
void print_sampling(const furrow::calib::Calibration& solved,
                    const std::vector<furrow::target::BoardDetection>& detections,
                    const furrow::calib::CalibrateOptions& options);
