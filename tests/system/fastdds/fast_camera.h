#pragma once

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "fast_node.h"
#include "peer_words.h"

namespace sprout::fast_peer {

using sensor_msgs::msg::CameraInfo;

inline void Stamp(std_msgs::msg::Header& header, double time) {
  header.stamp().sec(static_cast<int32_t>(std::floor(time)));
  header.stamp().nanosec(static_cast<uint32_t>((time - std::floor(time)) * 1e9));
}

inline uint32_t BytesOf(const std::string& encoding) {
  if (encoding == "bgr8" || encoding == "rgb8") return 3;
  if (encoding == "bgra8" || encoding == "32FC1") return 4;
  return encoding == "mono8" ? 1 : 2;
}

inline CameraInfo InfoOf(uint32_t width, uint32_t height, double focal, double baseline_m) {
  CameraInfo info;
  info.header().frame_id("camera");
  info.width(width);
  info.height(height);
  info.distortion_model("plumb_bob");
  info.d({0, 0, 0, 0, 0});
  const double cx = width / 2.0;
  const double cy = height / 2.0;
  info.k({focal, 0, cx, 0, focal, cy, 0, 0, 1});
  info.r({1, 0, 0, 0, 1, 0, 0, 0, 1});
  info.p({focal, 0, cx, -focal * baseline_m, 0, focal, cy, 0, 0, 0, 1, 0});
  return info;
}

// A wall 2 m ahead in the left camera's frame, 32 rows of 60 points.
inline sensor_msgs::msg::PointCloud2 Wall() {
  sensor_msgs::msg::PointCloud2 wall;
  wall.header().frame_id("camera");
  wall.height(1);
  wall.width(32 * 60);
  wall.point_step(16);
  wall.row_step(wall.width() * wall.point_step());
  for (const char* name : {"x", "y", "z", "intensity"}) {
    sensor_msgs::msg::PointField field;
    field.name(name);
    field.offset(4 * static_cast<uint32_t>(wall.fields().size()));
    field.datatype(7);  // FLOAT32
    field.count(1);
    wall.fields().push_back(field);
  }
  wall.data().resize(wall.row_step());
  for (uint32_t i = 0; i < wall.width(); ++i) {
    const float point[4] = {-1 + static_cast<float>(i % 60) / 30,
                            -0.5F + static_cast<float>(i / 60) / 32, 2, 1};
    std::memcpy(&wall.data()[size_t{16} * i], point, sizeof point);
  }
  return wall;
}

class Camera {
 public:
  Camera(Node& node, const std::string& rig, uint32_t width, uint32_t height,
         const Options& options)
      : width_(width), height_(height), options_(options) {
    const Qos qos{.reliable = !options.Has("best_effort")};
    const std::string info = options.Get("info", "volatile");
    const Qos info_qos{.reliable = true, .latched = info == "latched"};
    is_latched_ = info == "latched";
    for (int side = 0; side < 2; ++side) {
      const std::string base = "rt" + rig + (side == 0 ? "/left" : "/right");
      images_[side] = node.Writer<sensor_msgs::msg::ImagePubSubType>(base + "/image_rect", qos);
      if (info == "none") continue;
      infos_[side] =
          node.Writer<sensor_msgs::msg::CameraInfoPubSubType>(base + "/camera_info", info_qos);
    }
    if (options.Has("points")) {
      points_ = node.Writer<sensor_msgs::msg::PointCloud2PubSubType>("rt" + rig + "/points", qos);
      wall_ = Wall();
    }
    if (options.Has("texture")) MakeTexture();
    const std::string encoding = options.Get("encoding", "mono8");
    image_.header().frame_id("camera");
    image_.width(width);
    image_.height(height);
    image_.encoding(encoding);
    image_.step(width * BytesOf(encoding));
    const auto huge = static_cast<size_t>(options.Number("huge", 0));
    if (huge > 0) image_.height(static_cast<uint32_t>(huge / image_.step()));
    image_.data().resize(size_t{image_.step()} * image_.height());
  }

  void WaitForSubscriber() const {
    for (const double end = Now() + options_.Number("wait", 10); Now() < end && !has_to_end;) {
      dds::PublicationMatchedStatus left;
      dds::PublicationMatchedStatus right;
      images_[0]->get_publication_matched_status(left);
      images_[1]->get_publication_matched_status(right);
      if (left.current_count > 0 && right.current_count > 0) return;
      if (infos_[0] != nullptr) SendInfos(0, Now());  // a subscriber may want it first
      SleepTo(Now() + 0.05);
    }
  }

  void Send(int number) {
    const double shift =
        number >= options_.Number("jump_at", 1e9) ? options_.Number("jump_s", 0) : 0;
    const double stamp = Now() + shift;
    if (infos_[0] != nullptr && (!is_latched_ || number == 0)) SendInfos(number, stamp);
    Stamp(image_.header(), stamp);
    for (int side = 0; side < 2; ++side) {
      texture_.empty() ? static_cast<void>(std::memset(image_.data().data(), number % 251 + side,
                                                       image_.data().size()))
                       : ShowWall(number, side);
      failed_ += images_[side]->write(&image_) ? 0 : 1;
    }
    if (points_ == nullptr) return;
    Stamp(wall_.header(), stamp);
    points_->write(&wall_);
  }

  int failed() const { return failed_; }

 private:
  // Squares of random grey levels, wider than the image by the disparity of a wall 2 m ahead.
  void MakeTexture() {
    constexpr uint32_t kSquare = 4;
    texture_width_ = width_ + kWallDisparity;
    texture_.resize(size_t{texture_width_} * height_);
    for (uint32_t y = 0; y < height_; ++y) {
      for (uint32_t x = 0; x < texture_width_; ++x) {
        uint32_t level = (y / kSquare) * 7919 + x / kSquare;
        level = (level ^ (level >> 7)) * 2654435761U;
        texture_[size_t{y} * texture_width_ + x] = static_cast<uint8_t>(level >> 24);
      }
    }
  }

  // The wall moves up by two rows a frame. mono8.
  void ShowWall(int number, int side) {
    for (uint32_t y = 0; y < height_; ++y) {
      const uint32_t row = (y + 2 * static_cast<uint32_t>(number)) % height_;
      std::memcpy(&image_.data()[size_t{y} * width_],
                  &texture_[size_t{row} * texture_width_ + (side == 0 ? 0 : kWallDisparity)],
                  width_);
    }
  }

  void SendInfos(int number, double stamp) const {
    const double focal = number >= options_.Number("focal_at", 1e9) ? 640 : 320;
    for (int side = 0; side < 2; ++side) {
      CameraInfo info = InfoOf(width_, height_, focal, side == 0 ? 0 : 0.1);
      Stamp(info.header(), stamp);
      infos_[side]->write(&info);
    }
  }

  static constexpr uint32_t kWallDisparity = 16;  // f·b/z = 320·0.1/2, px
  uint32_t width_, height_;
  uint32_t texture_width_ = 0;
  std::vector<uint8_t> texture_;
  const Options& options_;
  dds::DataWriter* images_[2] = {};
  dds::DataWriter* infos_[2] = {};
  dds::DataWriter* points_ = nullptr;
  bool is_latched_ = false;
  sensor_msgs::msg::Image image_;
  sensor_msgs::msg::PointCloud2 wall_;
  int failed_ = 0;
};

}  // namespace sprout::fast_peer
