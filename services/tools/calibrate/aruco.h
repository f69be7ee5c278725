#pragma once

#include <opencv2/core.hpp>
#include <vector>
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
#include <opencv2/objdetect/aruco_dictionary.hpp>
#else
#include <opencv2/aruco/dictionary.hpp>
#endif

namespace cv::aruco {
class CharucoBoard;
}

/// OpenCV's markers by one set of names: version 4.7 renamed them and moved them from contrib to
/// objdetect.
namespace sprout::calibrate::aruco {

using cv::aruco::CharucoBoard;
using cv::aruco::Dictionary;

/// Corners of a marker, clockwise from its upper left one.
using Quad = std::vector<cv::Point2f>;

/// @param number  one of OpenCV's, such as cv::aruco::DICT_4X4_250.
Dictionary OpenDictionary(int number);

/// @param square,marker  sides, m.
cv::Ptr<CharucoBoard> MakeCharuco(cv::Size squares, double square, double marker,
                                  const Dictionary& dictionary);

const Dictionary& DictionaryOf(const CharucoBoard& board);

/// Corners of each marker on the board, m, by its number.
const std::vector<std::vector<cv::Point3f>>& MarkersOf(const CharucoBoard& board);

/// The board without a margin.
cv::Mat1b Draw(const cv::Ptr<CharucoBoard>& board, cv::Size size);

/// A marker of `side` px.
cv::Mat1b DrawMarker(const Dictionary& dictionary, int id, int side, int border_bits);

void FindMarkers(const cv::Mat1b& image, const Dictionary& dictionary, std::vector<Quad>& markers,
                 std::vector<int>& ids, int border_bits = 1);

/// The inner corners of the chessboard near markers that were found, px, and their numbers.
void FindCorners(const cv::Mat1b& image, const cv::Ptr<CharucoBoard>& board,
                 const std::vector<Quad>& markers, const std::vector<int>& marker_ids,
                 std::vector<cv::Point2f>& pixels, std::vector<int>& ids);

}  // namespace sprout::calibrate::aruco
