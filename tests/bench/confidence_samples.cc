// Features and errors of sampled pixels of the whole chain, for scripts/tune_confidence:
// sprout_confidence_samples ROW TOF NOISE_PX IMAGES SCENE... prints a line for each: row, scene,
// error in px, whether both cameras see it, then the features in the order of ConfidenceModel.
#include <cmath>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>
#include <string>

#include "common/core/image.h"
#include "common/core/number_text.h"
#include "services/grow/confidence/confidence.h"
#include "services/tools/evaluate/chain.h"
#include "services/tools/evaluate/scene.h"

namespace sprout::evaluate {
namespace {

constexpr int kSamples = 1000;  // a scene

// As poorer cameras give it: "good", or a fault and how much of it, as in "jpeg:10".
cv::Mat Worse(const cv::Mat& image, const std::string& how) {
  if (how == "good") return image;
  const size_t colon = how.find(':');
  const std::string fault = how.substr(0, colon);
  const std::optional<double> much =
      colon == std::string::npos ? std::nullopt : ParseNumber<double>(how.substr(colon + 1));
  cv::Mat worse;
  if (much && fault == "light") {
    image.convertTo(worse, -1, *much);
  } else if (much && fault == "blur") {
    cv::GaussianBlur(image, worse, {}, *much);
  } else if (much && fault == "noise") {
    cv::Mat noise(image.size(), CV_MAKETYPE(CV_16S, image.channels()));
    cv::theRNG().fill(noise, cv::RNG::NORMAL, 0, *much);
    cv::add(image, noise, worse, {}, image.depth());
  } else if (much && fault == "jpeg") {
    std::vector<uchar> bytes;
    cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, cvRound(*much)});
    worse = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } else {
    throw ConfigError(how +
                      ": allowed are good, light:FACTOR, blur:PX, noise:LEVELS, jpeg:QUALITY");
  }
  return worse;
}

void PrintScene(const std::string& row, const Scene& scene, const ChainSettings& settings) {
  Frame frame = FrameOf(scene);
  StageTimes ms;
  RunSteps(scene, settings, ChainStep::kFinish, frame, ms);
  const DisparityImage& map = *frame.disparity;
  grow::ConfidenceEstimator estimator;
  estimator.Compute({scene.left_grey, scene.right_grey, frame.seeds->seeds, frame.prior->sigma,
                     *frame.unfilled, map});
  const grow::ConfidenceFeatures& features = estimator.features();
  std::mt19937 random(1);
  const auto below = [&](int end) {
    return static_cast<int>(random() % static_cast<unsigned>(end));
  };
  int found = 0;
  for (int i = 0; i < 20 * kSamples && found < kSamples; ++i) {
    const int u = below(map.width());
    const int v = below(map.height());
    const float truth = scene.frame.truth.left(v, u);
    // Beside a point of a scan its truth is the point itself.
    const bool is_test = !scene.truth_is_scan || scene.away(v, u) != 0;
    if (!std::isfinite(truth) || !map.IsValid(u, v) || !is_test) continue;
    ++found;
    std::cout << row << '\t' << scene.name << '\t' << map.Px(u, v) - truth << '\t'
              << (scene.nonoccluded(v, u) != 0);
    const cv::Point cell(u / grow::kCellPx, v / grow::kCellPx);
    for (const cv::Mat1b* plane :
         {&features.step, &features.bend, &features.margin, &features.edge}) {
      std::cout << '\t' << int{(*plane)(cell)};
    }
    const cv::Point block(u / grow::kBlockPx, v / grow::kBlockPx);
    std::cout << '\t' << int{features.tof_seed(block)} << '\t' << int{features.seed(block)} << '\t'
              << int{frame.prior->sigma(v / 2 * 2, u / 2 * 2)} << '\t' << int{features.gaps(cell)}
              << '\t' << int{features.blank(cell)} << '\t' << int{features.rough(block)} << '\n';
  }
}

int Main(int argc, char** argv) {
  if (argc < 6) {
    std::cerr << "usage: sprout_confidence_samples ROW TOF NOISE_PX IMAGES SCENE...\n";
    return 2;
  }
  ChainSettings settings{.config = LoadConfig({"default"}), .noise = {}, .fgs = {}};
  settings.config.mutable_grow()->set_publish_confidence(false);
  settings.config.mutable_grow()->set_publish_unfilled(true);
  settings.noise.disparity_px = settings.noise.jitter_px = std::stod(argv[3]);
  cv::setNumThreads(1);
  for (int i = 5; i < argc; ++i) {
    for (const std::string& name : ScenesOf(argv[i])) {
      Scene scene = LoadScene(name, TofChoice(argv[2]), settings.config.capture());
      scene.frame.left = Worse(scene.frame.left, argv[4]);
      scene.frame.right = Worse(scene.frame.right, argv[4]);
      scene.left_grey = ToGrey(scene.frame.left);
      scene.right_grey = ToGrey(scene.frame.right);
      PrintScene(argv[1], scene, settings);
    }
  }
  return 0;
}

}  // namespace
}  // namespace sprout::evaluate

int main(int argc, char** argv) { return sprout::evaluate::Main(argc, argv); }
