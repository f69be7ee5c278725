#include "services/calibrate/board_page.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "common/config/config_error.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout::calibrate {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(BoardPage, IsPrintedAtTrueScale) {
  const Board board({.columns = 9, .rows = 6, .square_m = 0.06});
  const TemporaryDirectory folder;
  const std::string page = folder / "board.pdf";
  std::ofstream(page) << BoardPage(board, page);
  // 50.8 dots an inch are 2 dots a mm.
  ASSERT_EQ(
      std::system(("pdftoppm -r 50.8 -gray -singlefile '" + page + "' '" + page + "'").c_str()), 0);
  const cv::Mat print = cv::imread(page + ".pgm", cv::IMREAD_GRAYSCALE);

  ASSERT_EQ(print.size(), cv::Size(1140, 810));  // 9 x 6 squares, margins and footer
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids;
  cv::aruco::detectMarkers(print, board.charuco()->dictionary, markers, ids);
  std::vector<cv::Point2f> corners;
  std::vector<int> corner_ids;
  cv::aruco::interpolateCornersCharuco(markers, ids, print, board.charuco(), corners, corner_ids);
  ASSERT_EQ(static_cast<int>(corners.size()), board.corner_count());
  for (size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d corner_mm = 1000 * board.corner(corner_ids[i]);
    EXPECT_NEAR(corners[i].x, 2 * (corner_mm.x() + 15), 1);
    EXPECT_NEAR(corners[i].y, 2 * (corner_mm.y() + 15), 1);
  }
}

TEST(BoardPage, IsAPdfOrSvgFileOfTheSameBytes) {
  const Board board({.columns = 9, .rows = 6, .square_m = 0.06});

  EXPECT_THAT(BoardPage(board, "board.pdf"), StartsWith("%PDF-"));
  EXPECT_EQ(BoardPage(board, "a.pdf"), BoardPage(board, "b.pdf"));
  // 570 x 405 mm in points.
  EXPECT_THAT(BoardPage(board, "board.svg"), HasSubstr("viewBox=\"0 0 1615.748031 1148.031496\""));
  EXPECT_THROW(BoardPage(board, "board.png"), ConfigError);
}

}  // namespace
}  // namespace sprout::calibrate
