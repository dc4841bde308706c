#pragma once
#include <string>

#include "furrow/calib/calibrate.h"

namespace furrow::calib {

/// What was solved, as mrcal keeps it in a .cameramodel (numpy's npz in base 85), for
/// camera::to_mrcal_cameramodel(): mrcal's own tools then compute their uncertainty from it. Empty where
/// mrcal has no such problem: a fisheye, a board whose squares are not square or whose corners are not evenly
/// spaced. mrcal's regularisation is switched off, as Furrow has none, but for splined lenses, whose outer
/// knots need it.
std::string mrcal_optimization_inputs(const Calibration& calibration);

}  // namespace furrow::calib
