#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/scenes/dataset.h"

namespace sprout::scenes {

/// Frames in KITTI's own layout, real stereo with a real scan of a Velodyne HDL-64E (Geiger et al.,
/// IJRR 2013; Menze and Geiger, CVPR 2015):
///
///   image_2/ID_10.png, image_3/ID_10.png         left and right image, rectified; or ID.png, as in
///                                                the object set
///   calib/ID.txt                                 ReadKittiCalibration(); with tof = none the pair
///                                                alone, also of calib_cam_to_cam/ID.txt (2015)
///   velodyne/ID.bin                              ReadVelodyneScan(); not read with tof = none
///   disp_occ_0/ID_10.png, disp_noc_0/ID_10.png   truth, 16 bit: disparity in px = code / 256, 0 =
///                                                unknown; with and without the pixels that the
///                                                right camera does not see. Either may be missing,
///                                                the object set has none. disp_occ, disp_noc: 2012
///
/// Also an odometry sequence (image_2 and image_3, or the grey image_0 and image_1; calib.txt;
/// velodyne/ID.bin) and a raw drive (image_02/data and image_03/data, or image_00 and image_01;
/// velodyne_points/data; calib_cam_to_cam.txt and calib_velo_to_cam.txt there or in the folder
/// above), rectified ("sync") images. Neither has truth.
///
/// The scan becomes a range image at the left camera's position (TofImageFromScan()), with
/// config.beams() beams (KeepBeams()). Truth is of the left image only; without disp_noc_0 all of
/// it counts as seen by both cameras.
///
/// @param place  FOLDER/ID: one frame. FOLDER: all frames, in the order of their names; they must
///               have the same calibration. Files are read when their frame is asked for; those of
///               the first frame also at once.
/// @throws ConfigError naming what is missing or wrong, and where; Get() does so, too.
std::unique_ptr<Dataset> OpenKitti(const std::string& place, const CaptureConfig& config);

/// The places (FOLDER/ID) of the frames that OpenKitti() finds at a place.
/// @throws ConfigError when there is none.
std::vector<std::string> KittiPlaces(const std::string& place);

}  // namespace sprout::scenes
