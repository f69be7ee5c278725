#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "common/scenes/dataset.h"
#include "tests/system/graph.h"
#include "tests/system/run_program.h"

namespace sprout {
namespace {

// One frame of a synthetic scene, to send by hand.
struct HandFrame {
  explicit HandFrame(const std::string& source = "synthetic:160x120") {
    const auto frames = scenes::OpenDataset(source);
    frame = frames->Get(0);
    rig = frames->rig();
  }

  void Send(Graph& graph, int64_t seq) const {
    graph.PublishFrame(1000 + seq, seq, rig, frame.left, frame.right, frame.tof);
  }

  scenes::DatasetFrame frame;
  Rig rig;
};

// The frame with images that stereo cannot match.
HandFrame WithoutTexture(const HandFrame& of) {
  HandFrame frame = of;
  frame.frame.left = cv::Mat(of.frame.left.size(), of.frame.left.type(), cv::Scalar::all(100));
  frame.frame.right = cv::Mat(of.frame.right.size(), of.frame.right.type(), cv::Scalar::all(100));
  return frame;
}

bool HasDisparity(Graph& graph, int64_t seq, bool valid) {
  const auto found = graph.parts.find({Part::kDisparity, seq});
  return found != graph.parts.end() &&
         (std::get<DisparityImage>(found->second).CountValid() > 0) == valid;
}

// Share of the pixels at which two maps agree to 1 px.
double ShareAlike(const DisparityImage& one, const DisparityImage& other) {
  int alike = 0;
  for (int v = 0; v < one.size().height; ++v) {
    for (int u = 0; u < one.size().width; ++u) {
      if (!one.IsValid(u, v) || !other.IsValid(u, v)) continue;
      const int apart = std::abs(one.counts()(v, u) - other.counts()(v, u));
      if (apart <= DisparityImage::kCountsPerPixel) ++alike;
    }
  }
  return alike / static_cast<double>(one.size().area());
}

TEST(BadInputSystem, FramesWithoutToFGetAMapFromStereoAndTheStatusSaysSo) {
  Graph graph;
  graph.StartChain();
  const HandFrame good;
  HandFrame no_return = good;
  no_return.frame.tof.depth_m = cv::Mat1f(good.frame.tof.depth_m.size(), std::nanf(""));
  HandFrame no_image = good;
  no_image.frame.tof = TofImage();
  HandFrame no_camera = no_image;
  no_camera.rig.tof = {};
  const auto covered = [&](int64_t seq, bool some) {
    return graph.WaitUntil([&](Graph& g) {
      if (!g.parts.contains({Part::kDisparity, seq})) return false;
      for (const char* stage : kChain) {
        const StageStatus& status = g.statuses[stage];
        if (status.newest_frame.seq != seq) return false;
        if (some ? status.tof_coverage <= 0.5F : status.tof_coverage != 0) return false;
      }
      return true;
    });
  };
  int64_t seq = 0;
  for (const HandFrame* without : {&no_return, &no_image, &no_camera}) {
    good.Send(graph, seq);
    EXPECT_TRUE(covered(seq, true)) << graph.statuses["refine"].tof_coverage;
    without->Send(graph, seq + 1);
    EXPECT_TRUE(covered(seq + 1, false)) << graph.statuses["refine"].last_error;
    graph.Look([&](Graph& g) {
      const auto map = [&](int64_t of) {
        return std::get<DisparityImage>(g.parts.at({Part::kDisparity, of}));
      };
      EXPECT_GT(ShareAlike(map(seq), map(seq + 1)), 0.7) << "frame " << seq + 1;
    });
    seq += 2;
  }
}

TEST(BadInputSystem, DegenerateFramesAreAnsweredEmptyAndTheNextOneIsWhole) {
  Graph graph;
  graph.StartChain();
  const HandFrame good;
  HandFrame no_return = WithoutTexture(good);
  no_return.frame.tof.depth_m = cv::Mat1f(good.frame.tof.depth_m.size(), std::nanf(""));
  HandFrame two_points = no_return;
  two_points.frame.tof.depth_m = no_return.frame.tof.depth_m.clone();
  const cv::Mat1f& depth_m = good.frame.tof.depth_m;
  const int row = depth_m.rows / 2;
  int copied = 0;
  for (int u = depth_m.cols / 2; u < depth_m.cols && copied < 2; ++u) {
    two_points.frame.tof.depth_m(row, u) = depth_m(row, u);
    ++copied;
  }
  HandFrame one_line = no_return;
  one_line.frame.tof.depth_m = no_return.frame.tof.depth_m.clone();
  depth_m.row(row).copyTo(one_line.frame.tof.depth_m.row(row));

  no_return.Send(graph, 0);
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) { return HasDisparity(g, 0, false); }));
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["refine"].last_error.find(
               "no ToF point has a return, and stereo found none") != std::string::npos &&
           g.statuses["grow"].frames_degenerate == 1;
  }));
  two_points.Send(graph, 1);
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) { return HasDisparity(g, 1, false); }));
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["prior"].last_error.find("at least 3") != std::string::npos;
  }));
  one_line.Send(graph, 2);
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) { return HasDisparity(g, 2, false); }));
  good.Send(graph, 3);
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) { return HasDisparity(g, 3, true); }));
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["grow"].frames_degenerate == 3 && g.statuses["grow"].frames_out == 4;
  }));
}

TEST(BadInputSystem, ImagesSmallerThanTheWindowAreAnsweredEmpty) {
  Graph graph;
  graph.StartChain();
  HandFrame tiny;
  tiny.rig.pair.width = 4;
  tiny.rig.pair.height = 3;
  tiny.rig.pair.cx = tiny.rig.pair.cx_right = 2;
  tiny.rig.pair.cy = 1.5;
  tiny.rig.pair.focal_px = 5;
  tiny.frame.left = cv::Mat(3, 4, CV_8UC1, cv::Scalar(100));
  tiny.frame.right = cv::Mat(3, 4, CV_8UC1, cv::Scalar(100));
  tiny.Send(graph, 0);
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) { return HasDisparity(g, 0, false); }));
  EXPECT_TRUE(graph.WaitUntil([](Graph& g) {
    return g.statuses["grow"].last_error.find("smaller than the 5x5 window") != std::string::npos;
  }));
}

TEST(BadInputSystem, WrongFlagsEndWithExitCode2AndOneLine) {
  const struct {
    std::string stage;
    std::vector<std::string> flags;
    std::string message;  // part of the one line
  } cases[] = {
      {"capture", {"--source", "middlebury:/nonexistent"}, "/nonexistent"},
      {"capture", {"--source", "webcam:0"}, "webcam"},
      {"capture", {"--source", "synthetic:4x4"}, "4x4"},
      {"capture", {"--source", "log:run.lcm", "--gt-scale", "4"}, "--gt-scale: of no use for"},
      {"capture", {"--gt-scale", "4"}, "with middlebury:DIR"},
      {"capture", {"--rate", "-1"}, "capture.rate_hz = -1"},
      {"capture", {"--rate", "nan"}, "capture.rate_hz = nan"},
      {"capture", {"--lockstep", "0"}, "--lockstep"},
      {"capture", {"--lockstep-timeout", "nan"}, "--lockstep-timeout: 'nan' is not allowed"},
      {"capture", {"--wait-timeout", "nan"}, "--wait-timeout: 'nan' is not allowed"},
      {"capture", {"--lcm-url", "udpm://239.255.76.67:7667?ttl=-5"}, "ttl=-5"},
      {"capture", {"--frames", "0"}, "--frames"},
      {"check-stage", {"--timeout", "nan"}, "--timeout: 'nan' is not allowed"},
      {"check-stage", {"--start-timeout", "nan"}, "--start-timeout: 'nan' is not allowed"},
      {"refine", {"--config", "/nonexistent.textproto"}, "/nonexistent.textproto"},
      {"prior", {"--nonsense"}, "--nonsense"},
      {"grow", {"--channel-prefix", "a b"}, "--channel-prefix"},
      {"grow", {"--log-level", "loud"}, "--log-level"},
      {"grow", {"--config", ""}, "--config '': allowed is a text that is not empty"},
      {"capture", {"--source", "log:/dev/null?rig="}, "rig"},
      {"capture", {"--wait-for", ""}, "--wait-for ''"},
      {"record", {"--dir", "/dev/null/logs"}, "--dir /dev/null/logs: cannot be used"},
#ifdef SPROUT_WITH_VIEW
      {"view", {"--log", ""}, "--log ''"},
      {"view", {"--log", "/etc/passwd"}, "--log: /etc/passwd"},
#endif
  };
  for (const auto& [stage, flags, message] : cases) {
    SCOPED_TRACE(stage + " " + flags[0]);
    std::vector<std::string> command = {"sprout-" + stage};
    command.insert(command.end(), flags.begin(), flags.end());
    const std::string said = OutputOf(command, 2);
    std::string lines;
    std::istringstream output(said);
    for (std::string line; std::getline(output, line);) {
      if (line.starts_with("sprout-" + stage + ": ")) lines += line + "\n";
    }
    EXPECT_THAT(lines, testing::HasSubstr(message)) << said;
    EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 1) << said;
  }
}

}  // namespace
}  // namespace sprout
