// Boards found, fit and time of calibration on every set at hand, with OpenCV and mrcal on the same corners
// in the same run.
//
//   bench_calibration [--data DIR] [--finders] [--sampling] [--no-mrcal] [NAME...]
//
// --finders also runs OpenCV's two finders and mrgingham (minutes on large pictures) and solves their
// corners. --sampling re-solves each set 200 times with fresh noise and compares the scatter with the claims.
// RMS is sqrt(sum of squared distances / corners) for all; mrcal prints it per coordinate, so its number is
// multiplied by sqrt(2). Solve times are CPU times, start values included; mrcal's is the sum over
// mrcal.optimize() and its seed inside its own program, and "in all" that program's, Python's start included.
// mrcal is told the focal length, Furrow and OpenCV are not.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "calib/synthetic.h"
#include "calibration_sampling.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/calib/calibrate.h"
#include "furrow/camera/compare.h"
#include "furrow/camera/model_files.h"
#include "furrow/geom/hull.h"
#include "furrow/stats/robust.h"

namespace fs = std::filesystem;
using namespace furrow;

namespace {

struct Set {
  const char* name;
  const char* pattern;
  int corners_x, corners_y;
  double square_m;
};
constexpr Set kSets[] = {
    {"opencv-left", "/usr/share/doc/opencv-doc/examples/data/left??.jpg", 9, 6, 0.025},
    {"opencv-right", "/usr/share/doc/opencv-doc/examples/data/right??.jpg", 9, 6, 0.025},
    {"gopro", "calib/gopro-hero4-udacity/images/*.jpg", 8, 6, 0.03},
    {"sourishg", "calib/sourishg-left/images/*.jpg", 9, 6, 0.02423},
    {"sony", "calib/boofcv-sony-hx5v/images/*.jpg", 6, 4, 0.03},
    {"bumblebee-left", "calib/boofcv-bumblebee2-left/images/*.jpg", 6, 4, 0.03},
    {"bumblebee-right", "calib/boofcv-bumblebee2-right/images/*.jpg", 6, 4, 0.03},
    {"tello", "calib/tello-archdrone/images/*.jpg", 7, 7, 0.03},
    {"mini-se", "flights/mini-se/checkerboard/*.jpg", 9, 6, 0.025},
    {"theta-fisheye", "calib/boofcv-fisheye-theta/images/*.jpg", 6, 4, 0.03},
};

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// CPU time of this program, s: what a solve costs whatever else the machine does.
double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct OpenCvResult {
  double rms_px, fx, time_s;
};

OpenCvResult opencv_solves(const std::vector<target::BoardDetection>& detections,
                           const target::BoardSpec& board) {
  std::vector<std::vector<cv::Point3f>> in_board;
  std::vector<std::vector<cv::Point2f>> px;
  cv::Size size;
  for (const auto& one : detections) {
    if (!one.found) continue;
    size = {one.width, one.height};
    in_board.emplace_back();
    px.emplace_back();
    for (const auto& x : target::corners_in_board(board)) {
      in_board.back().emplace_back(static_cast<float>(x.x()), static_cast<float>(x.y()), 0.0F);
    }
    for (const auto& p : one.corners_px)
      px.back().emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  cv::Mat k, d;
  std::vector<cv::Mat> r, t;
  const double start = cpu_seconds();
  const double rms_px = cv::calibrateCamera(in_board, px, size, k, d, r, t, 0);
  return {rms_px, k.at<double>(0, 0), cpu_seconds() - start};
}

/// Runs mrcal's program on the same corners; nothing when it is not installed or fails.
struct MrcalResult {
  bool ok = false;
  Camera camera;
  Camera free;  ///< solved on with mrcal's regularisation off; no width where that failed
  double rms_px = 0.0;
  double all_s = 0.0;    ///< CPU time of the program, Python's start included
  double solve_s = 0.0;  ///< of these, in mrcal.optimize() and its seed
};

/// What mrcal is asked: its lens model, and whether corners weigh by their sigma and the board may bend, as
/// its users do.
struct MrcalProblem {
  std::string lensmodel = "LENSMODEL_OPENCV5";
  bool weights_and_warp = false;
};

/// mrcal's own program, with the time spent in its solver summed up.
constexpr const char* kTimedMrcal = R"(import mrcal, runpy, sys, time
spent = 0.0
def timed(f):
    def run(*a, **k):
        global spent
        start = time.process_time()
        try: return f(*a, **k)
        finally: spent += time.process_time() - start
    return run
mrcal.optimize = timed(mrcal.optimize)
mrcal.seed_stereographic = timed(mrcal.seed_stereographic)
try: runpy.run_path('/usr/bin/mrcal-calibrate-cameras', run_name='__main__')
finally: print('## spent', spent, time.process_time())
)";

/// Solves mrcal's own problem on, from its own answer, without the regularisation that Furrow has not.
constexpr const char* kFreeMrcal = R"(import glob, mrcal
model = mrcal.cameramodel(glob.glob('camera*.cameramodel')[0])
inputs = model.optimization_inputs()
inputs['do_apply_regularization'] = False
for again in range(5): mrcal.optimize(**inputs)
mrcal.cameramodel(optimization_inputs=inputs, icam_intrinsics=0).write('free.cameramodel')
)";

/// Number after the last `mark` in a log.
double number_after(const std::string& log, const std::string& mark) {
  const auto at = log.rfind(mark);
  return at == std::string::npos ? 0.0 : std::atof(log.c_str() + at + mark.size());
}

MrcalResult mrcal_solves(const std::vector<target::BoardDetection>& detections,
                         const target::BoardSpec& board, double focal_px, const MrcalProblem& problem = {}) {
  const fs::path folder = fs::temp_directory_path() / "furrow_bench_mrcal";
  fs::remove_all(folder);
  fs::create_directories(folder);
  std::ostringstream corners;
  corners << "# filename x y " << (problem.weights_and_warp ? "weight" : "level") << "\n";
  const target::BoardDetection* any = nullptr;
  for (const auto& one : detections) {
    if (!one.found) continue;
    any = &one;
    for (std::size_t c = 0; c < one.corners_px.size(); ++c) {
      corners << one.image << " " << base::format_double(one.corners_px[c].x()) << " "
              << base::format_double(one.corners_px[c].y()) << " "
              << (problem.weights_and_warp ? base::format_double(1.0 / one.sigma_px[c]) : "0") << "\n";
    }
  }
  if (any == nullptr || !base::write_file(folder / "corners.vnl", corners.str()).ok() ||
      !base::write_file(folder / "timed.py", kTimedMrcal).ok())
    return {};
  std::ostringstream command;
  command << "cd '" << folder.string() << "' && timeout 300 /usr/bin/python3 timed.py --lensmodel "
          << problem.lensmodel << " --focal " << focal_px << " --object-spacing " << board.square_m
          << " --object-width-n " << board.corners_x << " --object-height-n " << board.corners_y
          << " --imagersize " << any->width << " " << any->height
          << " --corners-cache corners.vnl --skip-outlier-rejection "
          << (problem.weights_and_warp ? "--corners-cache-has-weights " : "--skip-calobject-warp-solve ")
          << "--outdir . '*' > log.txt 2>&1";
  if (std::system(command.str().c_str()) != 0) return {};
  MrcalResult out;
  const auto files = base::expand_pattern("camera*.cameramodel", folder);
  if (!files.ok()) return {};
  const auto camera = camera::read_camera(files->front());
  const auto log = base::read_file(folder / "log.txt");
  if (!camera.ok() || !log.ok()) return {};
  out.camera = *camera;
  out.rms_px =
      std::sqrt(2.0) * number_after(*log, "## RMS error: ");  // one a stage; the last is the full solve
  const auto at = log->rfind("## spent ");
  if (at != std::string::npos) std::sscanf(log->c_str() + at, "## spent %lf %lf", &out.solve_s, &out.all_s);
  if (base::write_file(folder / "free.py", kFreeMrcal).ok() &&
      std::system(
          ("cd '" + folder.string() + "' && timeout 300 /usr/bin/python3 free.py > free.txt 2>&1").c_str()) ==
          0) {
    const auto free = camera::read_camera(folder / "free.cameramodel");
    if (free.ok()) out.free = *free;
  }
  out.ok = true;
  return out;
}

/// Outline of all corners that the boards of a solve showed.
std::vector<Eigen::Vector2d> covered(const calib::Calibration& calibration) {
  std::vector<Eigen::Vector2d> corners;
  for (const calib::View& view : calibration.views) {
    if (view.used) corners.insert(corners.end(), view.observed_px.begin(), view.observed_px.end());
  }
  return geom::convex_hull(corners);
}

/// Mean distance of two cameras' pixels, px: where boards were seen, and over the whole picture.
void print_difference(const char* from, const calib::Calibration& ours, const Camera& other) {
  constexpr int kColumns = 48, kRows = 32;
  const auto near = camera::compare_cameras(ours.camera, other, kColumns, kRows, covered(ours)),
             whole = camera::compare_cameras(ours.camera, other, kColumns, kRows);
  if (near.ok() && whole.ok())
    std::printf(
        "    from %s: mean %.4f px, largest %.3f px over the %.0f %% of the picture with boards; mean "
        "%.4f px over all of it\n",
        from, near->mean_px, near->largest_px, 100.0 * near->compared_share, whole->mean_px);
}

/// Boards as another finder sees them, in the form that our solve takes.
struct Finder {
  const char* name;
  bool (*find)(const cv::Mat& grey, const cv::Size& size, std::vector<cv::Point2f>& corners);
};

bool find_sector_based(const cv::Mat& grey, const cv::Size& size, std::vector<cv::Point2f>& corners) {
  return cv::findChessboardCornersSB(grey, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE);
}

bool find_classic(const cv::Mat& grey, const cv::Size& size, std::vector<cv::Point2f>& corners) {
  if (!cv::findChessboardCorners(grey, size, corners)) return false;
  cv::cornerSubPix(grey, corners, {5, 5}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 1e-3});
  return true;
}

std::vector<target::BoardDetection> found_by_opencv(const std::vector<fs::path>& files, const Set& set,
                                                    const Finder& finder) {
  std::vector<target::BoardDetection> out;
  for (const auto& file : files) {
    const auto picture = image::read_image(file);
    if (!picture.ok()) continue;
    Image grey = image::to_grey(*picture);
    const cv::Mat mat(grey.height, grey.width, CV_8U, grey.data.data());
    std::vector<cv::Point2f> corners;
    target::BoardDetection one;
    one.image = file.filename().string();
    one.width = grey.width;
    one.height = grey.height;
    one.found = finder.find(mat, {set.corners_x, set.corners_y}, corners);
    if (one.found)
      for (const auto& c : corners)
        one.corners_px.emplace_back(static_cast<double>(c.x), static_cast<double>(c.y));
    out.push_back(std::move(one));
  }
  return out;
}

/// mrgingham's program; it knows square boards only.
std::vector<target::BoardDetection> found_by_mrgingham(const std::vector<fs::path>& files, const Set& set) {
  const fs::path out_file = fs::temp_directory_path() / "furrow_bench_mrgingham.vnl";
  std::string command = "timeout 300 mrgingham --jobs 2 --gridn " + std::to_string(set.corners_x);
  for (const auto& file : files) command += " '" + file.string() + "'";
  if (std::system((command + " > '" + out_file.string() + "' 2> /dev/null").c_str()) != 0) return {};
  std::map<std::string, target::BoardDetection> by_name;
  const auto text = base::read_file(out_file);
  std::istringstream lines(text.ok() ? *text : "");
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name;
    double x = 0, y = 0;
    if (line.starts_with('#') || !(words >> name >> x >> y)) continue;
    by_name[name].corners_px.emplace_back(x, y);
  }
  std::vector<target::BoardDetection> out;
  for (auto& [name, one] : by_name) {
    const auto picture = image::read_image(name);
    one.image = name;
    one.width = picture.ok() ? picture->width : 0;
    one.height = picture.ok() ? picture->height : 0;
    one.found = true;
    out.push_back(std::move(one));
  }
  return out;
}

/// Names of the pictures in which `seen` has a board and `not_in` has none.
std::string only_in(const std::vector<target::BoardDetection>& seen,
                    const std::vector<target::BoardDetection>& not_in) {
  std::string out;
  for (const auto& one : seen) {
    const std::string name = fs::path(one.image).filename().string();
    const bool there = std::any_of(not_in.begin(), not_in.end(), [&](const auto& other) {
      return other.found && fs::path(other.image).filename() == name;
    });
    if (one.found && !there) out += " " + name;
  }
  return out;
}

/// Views that no solve fits: over five times the median view's RMS, the mark of a wrong grid.
std::string wrong_grids(const calib::Calibration& solved) {
  std::vector<double> rms_px;
  for (const calib::View& view : solved.views) {
    if (view.used) rms_px.push_back(view.rms_px);
  }
  constexpr double kWrong = 5.0;
  std::string out;
  for (const calib::View& view : solved.views) {
    if (view.used && view.rms_px > kWrong * stats::median(rms_px))
      out += " " + view.image + " (" + base::format_fixed(view.rms_px, 1) + " px)";
  }
  return out;
}

void print_finder(const char* name, const std::vector<target::BoardDetection>& seen, double time_s,
                  const target::BoardSpec& board, const std::vector<target::BoardDetection>& ours) {
  const auto found = std::count_if(seen.begin(), seen.end(), [](const auto& d) { return d.found; });
  const auto solved = calib::calibrate(seen, board);
  std::printf("    %-9s %3d boards %7.2f s  RMS after our solve %s px\n", name, static_cast<int>(found),
              time_s, solved.ok() ? base::format_fixed(solved->rms_px, 4).c_str() : "-");
  const std::string more = only_in(seen, ours), less = only_in(ours, seen),
                    wrong = solved.ok() ? wrong_grids(*solved) : "";
  if (!more.empty()) std::printf("      found by it and not by Furrow:%s\n", more.c_str());
  if (!less.empty()) std::printf("      found by Furrow and not by it:%s\n", less.c_str());
  if (!wrong.empty()) std::printf("      grids that fit no solve:%s\n", wrong.c_str());
  std::fflush(stdout);
}

void bench_finders(const std::vector<fs::path>& files, const Set& set, const target::BoardSpec& board,
                   const std::vector<target::BoardDetection>& ours) {
  for (const Finder& finder : {Finder{"SB", find_sector_based}, Finder{"classic", find_classic}}) {
    const double start = seconds();
    const auto seen = found_by_opencv(files, set, finder);
    print_finder(finder.name, seen, seconds() - start, board, ours);
  }
  if (set.corners_x != set.corners_y || std::system("command -v mrgingham > /dev/null") != 0) return;
  const double start = seconds();
  const auto seen = found_by_mrgingham(files, set);
  print_finder("mrgingham", seen, seconds() - start, board, ours);
}

void bench_set(const Set& set, const fs::path& data, bool finders, bool sampling, bool with_mrcal) {
  const auto files = base::expand_pattern(set.pattern, data);
  if (!files.ok()) {
    std::printf("%-16s not here: %s\n", set.name, files.error().message().c_str());
    return;
  }
  const target::BoardSpec board{set.name, set.corners_x, set.corners_y, set.square_m, 1.0};
  double start = seconds();
  const auto detections = target::detect_boards(*files, board, {}, 2);
  const double detect_s = seconds() - start;
  const auto found =
      std::count_if(detections.begin(), detections.end(), [](const auto& d) { return d.found; });
  start = cpu_seconds();
  const auto ours = calib::calibrate(detections, board);
  const double solve_s = cpu_seconds() - start;
  std::printf("%-16s %3d of %3zu boards %6.2f s", set.name, static_cast<int>(found), files->size(), detect_s);
  if (!ours.ok()) {
    std::printf("  %s\n", ours.error().message().c_str());
    return;
  }
  std::printf(" | furrow %.4f px %.3f s fx %.1f", ours->rms_px, solve_s, ours->camera.fx);
  const OpenCvResult opencv = opencv_solves(detections, board);
  std::printf(" | opencv %.4f px %.2f s fx %.1f", opencv.rms_px, opencv.time_s, opencv.fx);
  // Beyond 180 degrees no Brown-Conrady lens fits, and mrcal's solve runs away.
  constexpr double kFitsAtAll = 1.5;
  const MrcalResult mrcal = with_mrcal && ours->rms_px < kFitsAtAll
                                ? mrcal_solves(detections, board, ours->camera.fx)
                                : MrcalResult{};
  if (mrcal.ok) {
    std::printf(" | mrcal %.4f px %.3f s (%.1f s in all) fx %.1f", mrcal.rms_px, mrcal.solve_s, mrcal.all_s,
                mrcal.camera.fx);
  }
  std::printf("\n");
  const std::string wrong = wrong_grids(*ours);
  if (!wrong.empty()) std::printf("    grids that fit no solve:%s\n", wrong.c_str());
  if (mrcal.ok) {
    print_difference("mrcal", *ours, mrcal.camera);
    print_difference("mrcal without its regularisation", *ours, mrcal.free);
  }
  if (finders) bench_finders(*files, set, board, detections);
  if (sampling) print_sampling(*ours, detections, {});
  std::fflush(stdout);
}

/// The published corners of mrcal's 24-megapixel set: 186 views of 10 x 10 with weights.
void bench_mrcal_board(const fs::path& data, bool with_mrcal) {
  const fs::path folder = data / "calib/mrcal-board-24mp";
  const auto text = base::read_file(folder / "corners_weights.vnl");
  if (!text.ok()) return;
  std::vector<target::BoardDetection> detections;
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string image;
    double x = 0, y = 0, weight = 0;
    if (line.starts_with('#') || !(words >> image >> x >> y >> weight)) continue;
    if (detections.empty() || detections.back().image != image) {
      detections.emplace_back();
      detections.back().image = image;
      detections.back().width = 6016;
      detections.back().height = 4016;
      detections.back().found = true;
    }
    detections.back().corners_px.emplace_back(x, y);
    detections.back().sigma_px.push_back(weight > 0 ? 1.0 / weight : 1e6);
  }
  calib::CalibrateOptions options;
  options.model = camera::CameraModel::opencv8;
  options.use_corner_sigma = true;
  options.solve_warp = true;
  const target::BoardSpec board{"mrcal-board", 10, 10, 0.077, 1.0};
  const double start = cpu_seconds();
  const auto ours = calib::calibrate(detections, board, options);
  const double solve_s = cpu_seconds() - start;
  if (!ours.ok()) {
    std::printf("mrcal-board-24mp %s\n", ours.error().message().c_str());
    return;
  }
  std::printf("mrcal-board-24mp %zu views %.2f s, fx %.2f fy %.2f, warp %.3f %.3f mm", detections.size(),
              solve_s, ours->camera.fx, ours->camera.fy, 1e3 * ours->board_warp_x_m.value,
              1e3 * ours->board_warp_y_m.value);
  const MrcalResult mrcal =
      with_mrcal ? mrcal_solves(detections, board, ours->camera.fx, {"LENSMODEL_OPENCV8", true})
                 : MrcalResult{};
  if (mrcal.ok)
    std::printf(" | mrcal %.2f s (%.1f s in all), fx %.2f", mrcal.solve_s, mrcal.all_s, mrcal.camera.fx);
  std::printf("\n");
  if (mrcal.ok) {
    print_difference("mrcal", *ours, mrcal.camera);
    print_difference("mrcal without its regularisation", *ours, mrcal.free);
  }
  const auto published = camera::read_camera(folder / "opencv8-0.cameramodel");
  if (published.ok()) print_difference("mrcal's published solve", *ours, *published);
  options.model = camera::CameraModel::splined_stereographic;
  const double splined_start = cpu_seconds();
  const auto splined = calib::calibrate(detections, board, options);
  if (splined.ok()) {
    std::printf("mrcal-board-24mp splined %d x %d: %.2f s, RMS %.4f px (opencv8 %.4f px)",
                splined->camera.spline.columns, splined->camera.spline.rows, cpu_seconds() - splined_start,
                splined->rms_px, ours->rms_px);
    std::printf("\n");
    const auto published_splined = camera::read_camera(folder / "splined-0.cameramodel");
    if (published_splined.ok()) print_difference("mrcal's published solve", *splined, *published_splined);
    print_difference("opencv8 of the same corners", *splined, ours->camera);
  } else {
    std::printf("mrcal-board-24mp splined: %s\n", splined.error().message().c_str());
  }
}

void bench_growth() {
  for (const int views : {20, 100, 500, 2000}) {
    calib::Session how;
    how.views = views;
    const auto detections = calib::session(calib::true_camera(), calib::true_board(), how);
    const double start = cpu_seconds();
    const auto ours = calib::calibrate(detections, calib::true_board());
    const double time_s = cpu_seconds() - start;
    std::printf("synthetic %4d views %.3f s, %.3f ms a view, fx %.3f +- %.3f (truth %.3f)\n", views, time_s,
                1e3 * time_s / views, ours.ok() ? ours->camera.fx : 0.0,
                ours.ok() ? std::sqrt(ours->camera.covariance(0, 0)) : 0.0, calib::true_camera().fx);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const char* set_by_environment = std::getenv("FURROW_DATA");
  fs::path data = set_by_environment != nullptr ? set_by_environment : FURROW_SOURCE_DIR "/../shared/data";
  bool finders = false, sampling = false,
       with_mrcal = std::system("command -v mrcal-calibrate-cameras > /dev/null") == 0;
  std::vector<std::string> names;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--data" && i + 1 < argc) {
      data = argv[++i];
    } else if (word == "--finders") {
      finders = true;
    } else if (word == "--sampling") {
      sampling = true;
    } else if (word == "--no-mrcal") {
      with_mrcal = false;
    } else {
      names.push_back(word);
    }
  }
  for (const Set& set : kSets) {
    if (names.empty() || std::find(names.begin(), names.end(), set.name) != names.end()) {
      bench_set(set, data, finders, sampling, with_mrcal);
    }
  }
  if (names.empty()) {
    bench_mrcal_board(data, with_mrcal);
    bench_growth();
  }
  return 0;
}
