// Whether sprout::Pipeline gives the disparities that the services recorded:
//   same_as_services INPUT.lcm ANSWERS.lcm CONFIG
// Reads the images of every frame from one log and SPROUT_DISPARITY from the other. Exit code 0
// when at least one frame was compared and all are equal.
#include <sprout/log_reader.h>
#include <sprout/pipeline.h>

#include <cstring>
#include <iostream>
#include <lcmtypes/sprout/disparity_image_t.hpp>
#include <lcmtypes/sprout/image_t.hpp>
#include <lcmtypes/sprout/rig_t.hpp>
#include <lcmtypes/sprout/tof_image_t.hpp>
#include <map>

namespace {

struct Frame {
  cv::Mat left, right;
  sprout::TofImage tof;
  cv::Mat1s expected;
};

template <typename Message>
Message Decode(const sprout::LogEvent& event) {
  Message message;
  if (message.decode(event.data.data(), 0, static_cast<int>(event.data.size())) < 0) {
    throw std::runtime_error(std::string(event.channel) + " cannot be decoded");
  }
  return message;
}

cv::Mat ToMat(const sprout::image_t& message) {
  const bool grey = message.pixel_format == sprout::image_t::PIXEL_FORMAT_GREY;
  if (!grey && message.pixel_format != sprout::image_t::PIXEL_FORMAT_BGR3) {
    throw std::runtime_error("neither grey nor BGR");
  }
  return cv::Mat(message.height, message.width, grey ? CV_8UC1 : CV_8UC3,
                 const_cast<uint8_t*>(message.data.data()), static_cast<size_t>(message.row_stride))
      .clone();
}

cv::Mat1f Rows(const std::vector<float>& values, int rows) {
  if (values.empty()) return {};
  return cv::Mat1f(values, /*copyData=*/true).reshape(1, rows);
}

sprout::TofImage ToTof(const sprout::tof_image_t& message) {
  return {.depth_m = Rows(message.depth_m, message.height),
          .amplitude = Rows(message.amplitude, message.height)};
}

sprout::Rig ToRig(const sprout::rig_t& m) {
  sprout::Rig rig;
  rig.pair = {m.width, m.height, m.focal_px, m.cx, m.cy, m.cx_right, m.baseline_m};
  const double* q = m.left_from_tof_rotation;
  rig.tof = {m.tof_width,
             m.tof_height,
             m.tof_fx,
             m.tof_fy,
             m.tof_cx,
             m.tof_cy,
             {},
             Eigen::Quaterniond(q[0], q[1], q[2], q[3]),
             Eigen::Vector3d(m.left_from_tof_translation_m)};
  std::copy(std::begin(m.tof_distortion), std::end(m.tof_distortion), rig.tof.distortion.begin());
  return rig;
}

cv::Mat1s ToCounts(const sprout::disparity_image_t& m) {
  cv::Mat1s counts(m.height, m.width);
  if (m.data.size() != counts.total() * sizeof(int16_t)) throw std::runtime_error("compressed");
  std::memcpy(counts.data, m.data.data(), m.data.size());
  return counts;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) throw std::runtime_error("usage: same_as_services INPUT ANSWERS CONFIG");
  std::map<int64_t, Frame> frames;
  sprout::Rig rig;
  for (const char* path : {argv[1], argv[2]}) {
    sprout::LogReader log(path);
    for (sprout::LogEvent event; log.Next(event);) {
      if (event.channel == "SPROUT_LEFT" || event.channel == "SPROUT_RIGHT") {
        const auto message = Decode<sprout::image_t>(event);
        Frame& frame = frames[message.header.seq];
        (event.channel == "SPROUT_LEFT" ? frame.left : frame.right) = ToMat(message);
      } else if (event.channel == "SPROUT_TOF") {
        const auto message = Decode<sprout::tof_image_t>(event);
        frames[message.header.seq].tof = ToTof(message);
      } else if (event.channel == "SPROUT_RIG") {
        rig = ToRig(Decode<sprout::rig_t>(event));
      } else if (event.channel == "SPROUT_DISPARITY" && path == argv[2]) {
        const auto message = Decode<sprout::disparity_image_t>(event);
        frames[message.header.seq].expected = ToCounts(message);
      }
    }
  }
  sprout::Pipeline pipeline(sprout::LoadConfig({argv[3]}));
  int same = 0;
  for (const auto& [seq, frame] : frames) {
    const auto result = pipeline.Compute(frame.left, frame.right, frame.tof, rig);
    if (!result) throw std::runtime_error(result.error().text);
    const cv::Mat1s& counts = result->disparity.counts();
    if (counts.size() != frame.expected.size() ||
        std::memcmp(counts.data, frame.expected.data, counts.total() * sizeof(int16_t)) != 0) {
      throw std::runtime_error("frame " + std::to_string(seq) + " is not what the services made");
    }
    same += result->disparity.CountValid() > 0;
  }
  std::cout << same << " frames are the same\n";
  return same > 0 ? 0 : 1;
} catch (const std::exception& e) {
  std::cerr << "same_as_services: " << e.what() << "\n";
  return 1;
}
