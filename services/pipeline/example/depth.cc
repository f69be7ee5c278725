// Depth of a rectified pair and a coarse range image of the same view (PFM, m):
//   depth LEFT RIGHT RANGE.pfm FOCAL_PX CX_LEFT CX_RIGHT BASELINE_M DEPTH.pfm
#include <sprout/pipeline.h>

#include <iostream>
#include <opencv2/imgcodecs.hpp>

int main(int argc, char** argv) try {
  if (argc != 9) throw sprout::ConfigError("eight arguments are needed, see depth.cc");
  const cv::Mat left = cv::imread(argv[1]), right = cv::imread(argv[2]);
  const sprout::TofImage tof{.depth_m = cv::imread(argv[3], cv::IMREAD_UNCHANGED), .amplitude = {}};
  sprout::Rig rig;
  rig.pair = {.width = left.cols,
              .height = left.rows,
              .focal_px = std::stod(argv[4]),
              .cx = std::stod(argv[5]),
              .cy = (left.rows - 1) / 2.0,
              .cx_right = std::stod(argv[6]),
              .baseline_m = std::stod(argv[7])};
  const double scale = double(tof.depth_m.cols) / left.cols;  // in the left camera's place
  rig.tof.width = tof.depth_m.cols;
  rig.tof.height = tof.depth_m.rows;
  rig.tof.fx = rig.tof.fy = rig.pair.focal_px * scale;
  rig.tof.cx = (rig.pair.cx + 0.5) * scale - 0.5;
  rig.tof.cy = (rig.pair.cy + 0.5) * scale - 0.5;

  sprout::Pipeline pipeline(sprout::LoadConfig({"default"}));
  const auto frame = pipeline.Compute(left, right, tof, rig);
  if (!frame) throw sprout::ConfigError(frame.error().text);
  for (const std::string& warning : frame->warnings) std::cerr << warning << "\n";
  std::cout << frame->seeds.seeds.size() << " seeds, " << frame->disparity.CountValid()
            << " pixels with depth\n";
  return cv::imwrite(argv[8], frame->depth_m) ? 0 : 1;
} catch (const std::exception& e) {
  std::cerr << "depth: " << e.what() << "\n";
  return 2;
}
