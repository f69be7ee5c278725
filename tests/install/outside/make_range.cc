// A range image for the example: every tenth pixel of a true disparity map, as depth.
//   make_range DISPARITY.png DISPARITY_OFFSET_PX FOCAL_PX BASELINE_M RANGE.pfm
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

int main(int argc, char** argv) {
  if (argc != 6) return 2;
  const cv::Mat1b disparity = cv::imread(argv[1], cv::IMREAD_GRAYSCALE);
  cv::Mat1f depth(disparity.rows / 10, disparity.cols / 10);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const int px = disparity(10 * v + 5, 10 * u + 5);
      depth(v, u) = px == 0 ? std::numeric_limits<float>::quiet_NaN()
                            : static_cast<float>(std::atof(argv[3]) * std::atof(argv[4]) /
                                                 (px + std::atof(argv[2])));
    }
  }
  return cv::imwrite(argv[5], depth) ? 0 : 1;
}
