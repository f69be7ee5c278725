#include "tests/common/scenes/kitti_folder.h"

#include <utility>

namespace sprout::scenes {

KittiFolder::KittiFolder() {
  for (const char* name : {"image_2", "image_3", "disp_occ_0", "disp_noc_0", "calib", "velodyne"}) {
    std::filesystem::create_directory(files_.File(name));
  }
}

void KittiFolder::WriteViews(const std::string& name) const {
  files_.WriteImage("image_2/" + name, SomePicture({kWidth, kHeight}));
  files_.WriteImage("image_3/" + name, SomePicture({kWidth, kHeight}));
}

void KittiFolder::WriteStereo(const std::string& id) const {
  WriteObject(id);
  for (const std::string view : {"image_2/", "image_3/"}) {
    std::filesystem::rename(files_.File(view + id + ".png"), files_.File(view + id + "_10.png"));
  }
  cv::Mat1w codes(kHeight, kWidth, uint16_t{5 * 256});
  codes(0, 0) = 0;
  WriteTruth("disp_occ_0/" + id + "_10.png", codes);
}

void KittiFolder::WriteObject(const std::string& id) const {
  WriteViews(id + ".png");
  WriteCalibration(id);
  WriteScan(id, {{10, 0, 0, 0.5F}, {20, 1, -2, 0}, {-5, 0, 0, 0}});
}

void KittiFolder::WriteScan(const std::string& id, const std::vector<Point>& points) const {
  files_.WriteText("velodyne/" + id + ".bin",
                   {reinterpret_cast<const char*>(points.data()), points.size() * sizeof(Point)});
}

void KittiFolder::WriteTruth(const std::string& name, const cv::Mat1w& codes) const {
  files_.WriteImage(name, codes);
}

void KittiFolder::WriteCalibration(const std::string& id, const std::string& key,
                                   const std::string& value) const {
  std::string text = "P0: nobody reads this\n";
  for (const auto& [name, good] :
       {std::pair<std::string, std::string>{"P2", "100 0 20 0 0 100 15 0 0 0 1 0"},
        {"P3", "100 0 20 -50 0 100 15 0 0 0 1 0"},
        {"R0_rect", "1 0 0 0 1 0 0 0 1"},
        {"Tr_velo_to_cam", "0 -1 0 0 0 0 -1 0 1 0 0 0"}}) {
    const std::string& chosen = name == key ? value : good;
    if (!chosen.empty()) text += name + ": " + chosen + "\n";
  }
  files_.WriteText("calib/" + id + ".txt", text);
}

CaptureConfig KittiFolder::Config(const std::string& rest) const {
  CaptureConfig config;
  config.set_source("kitti:" + std::filesystem::path(place()).parent_path().string() + rest);
  return config;
}

}  // namespace sprout::scenes
