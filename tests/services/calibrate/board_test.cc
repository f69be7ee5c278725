#include "services/calibrate/board.h"

#include <gmock/gmock.h>

#include "common/config/config.h"

namespace sprout {
namespace {

using ::testing::HasSubstr;

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

TEST(BoardSvg, IsAtTrueScale) {
  const std::string svg = BoardSvg(Board({.columns = 9, .rows = 6, .square_m = 0.06}));

  // 9 and 6 squares and the margins; a module is an eighth of a square.
  EXPECT_THAT(svg, HasSubstr("width=\"570mm\" height=\"405mm\" viewBox=\"0 0 570 405\""));
  EXPECT_THAT(svg, HasSubstr("scale(7.5)"));
  EXPECT_THAT(svg, HasSubstr("M0 0h8v1h-8z"));  // the first black square begins
  EXPECT_THAT(svg, HasSubstr("h500m"));
  EXPECT_THAT(svg, HasSubstr("this line is 500 mm long"));
}

}  // namespace
}  // namespace sprout
