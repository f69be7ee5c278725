
#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <string>
#include <vector>

#include "common/config/config_error.h"
#include "services/tools/calibrate/board.h"
#include "tests/common/picture/temporary_directory.h"

namespace sprout::calibrate {
namespace {

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
  std::vector<aruco::Quad> markers;
  std::vector<int> ids;
  aruco::FindMarkers(print, aruco::DictionaryOf(*board.charuco()), markers, ids);
  std::vector<cv::Point2f> corners;
  std::vector<int> corner_ids;
  aruco::FindCorners(print, board.charuco(), markers, ids, corners, corner_ids);
  ASSERT_EQ(static_cast<int>(corners.size()), board.corner_count());
  for (size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d corner_mm = 1000 * board.corner(corner_ids[i]);
    EXPECT_NEAR(corners[i].x, 2 * (corner_mm.x() + 15), 1);
    EXPECT_NEAR(corners[i].y, 2 * (corner_mm.y() + 15), 1);
  }
}

TEST(BoardPage, IsAPdfOrSvgFileOfTheSameBytes) {
  const Board board({.columns = 9, .rows = 6, .square_m = 0.06});

  EXPECT_THAT(BoardPage(board, "board.pdf"), ::testing::StartsWith("%PDF-"));
  EXPECT_EQ(BoardPage(board, "a.pdf"), BoardPage(board, "b.pdf"));
  EXPECT_THROW(BoardPage(board, "board.png"), ConfigError);
}

// An attribute of an SVG's root as it is printed, mm.
double PrintedMm(const std::string& svg, const std::string& attribute) {
  // A number without a unit is in pixels, of which an inch has 96.
  const std::map<std::string, double> mm_of{{"", 25.4 / 96}, {"px", 25.4 / 96}, {"pt", 25.4 / 72},
                                            {"mm", 1},       {"cm", 10},        {"in", 25.4}};
  std::smatch found;
  const std::regex wanted("<svg[^>]* " + attribute + "=\"([0-9.]+)([a-z]*)\"");
  return std::regex_search(svg, found, wanted) ? std::stod(found[1]) * mm_of.at(found[2]) : 0;
}

TEST(BoardPage, AnSvgFileIsPrintedAtTrueScale) {
  const Board board({.columns = 9, .rows = 6, .square_m = 0.06});
  const std::string svg = BoardPage(board, "board.svg");
  // 9 x 6 squares, margins and footer.
  EXPECT_NEAR(PrintedMm(svg, "width"), 570, 0.1);
  EXPECT_NEAR(PrintedMm(svg, "height"), 405, 0.1);
  // What is drawn is in points, as in the PDF: so many are the page.
  std::smatch found;
  ASSERT_TRUE(std::regex_search(svg, found, std::regex("viewBox=\"0 0 ([0-9.]+) ([0-9.]+)\"")));
  EXPECT_NEAR(std::stod(found[1]), 570 * 72 / 25.4, 0.1);
  EXPECT_NEAR(std::stod(found[2]), 405 * 72 / 25.4, 0.1);
}

TEST(Board, HasACornerWhereFourSquaresMeet) {
  const Board board({.columns = 6, .rows = 4, .square_m = 0.05});
  const cv::Mat1b modules = board.Modules();

  ASSERT_EQ(modules.size(), cv::Size(48, 32));
  ASSERT_EQ(board.corner_count(), 5 * 3);
  for (int id = 0; id < board.corner_count(); ++id) {
    const Eigen::Vector3d modules_from_edge = board.corner(id) / 0.05 * 8;
    const int x = static_cast<int>(std::lround(modules_from_edge.x()));
    const int y = static_cast<int>(std::lround(modules_from_edge.y()));
    EXPECT_EQ(modules(y, x), modules(y - 1, x - 1)) << id;
    EXPECT_EQ(modules(y - 1, x), modules(y, x - 1)) << id;
    EXPECT_NE(modules(y, x), modules(y - 1, x)) << id;
  }
}

TEST(Board, RefusesWhatCannotBePrintedOrFound) {
  EXPECT_THROW(Board({.columns = 2, .rows = 6, .square_m = 0.05}), ConfigError);
  EXPECT_THROW(Board({.columns = 2'000'000'000, .rows = 2'000'000'000, .square_m = 0.05}),
               ConfigError);
  EXPECT_THROW(Board({.columns = 9, .rows = 6, .square_m = 0}), ConfigError);
  EXPECT_THROW(Board({.columns = 9, .rows = 6, .square_m = std::nan("")}), ConfigError);
}

}  // namespace

}  // namespace sprout::calibrate
