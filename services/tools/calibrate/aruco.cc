#include "services/tools/calibrate/aruco.h"

#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
#include <opencv2/objdetect/charuco_detector.hpp>
#else
#include <opencv2/aruco/charuco.hpp>
#endif

namespace sprout::calibrate::aruco {

#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7

Dictionary OpenDictionary(int number) { return cv::aruco::getPredefinedDictionary(number); }

cv::Ptr<CharucoBoard> MakeCharuco(cv::Size squares, double square, double marker,
                                  const Dictionary& dictionary) {
  return cv::makePtr<CharucoBoard>(squares, static_cast<float>(square), static_cast<float>(marker),
                                   dictionary);
}

const Dictionary& DictionaryOf(const CharucoBoard& board) { return board.getDictionary(); }

const std::vector<std::vector<cv::Point3f>>& MarkersOf(const CharucoBoard& board) {
  return board.getObjPoints();
}

cv::Mat1b Draw(const cv::Ptr<CharucoBoard>& board, cv::Size size) {
  cv::Mat1b picture;
  board->generateImage(size, picture, 0, 1);
  return picture;
}

cv::Mat1b DrawMarker(const Dictionary& dictionary, int id, int side, int border_bits) {
  cv::Mat1b picture;
  cv::aruco::generateImageMarker(dictionary, id, side, picture, border_bits);
  return picture;
}

void FindMarkers(const cv::Mat1b& image, const Dictionary& dictionary, std::vector<Quad>& markers,
                 std::vector<int>& ids, int border_bits) {
  cv::aruco::DetectorParameters parameters;
  parameters.markerBorderBits = border_bits;
  cv::aruco::ArucoDetector(dictionary, parameters).detectMarkers(image, markers, ids);
}

void FindCorners(const cv::Mat1b& image, const cv::Ptr<CharucoBoard>& board,
                 const std::vector<Quad>& markers, const std::vector<int>& marker_ids,
                 std::vector<cv::Point2f>& pixels, std::vector<int>& ids) {
  std::vector<Quad> known = markers;
  std::vector<int> known_ids = marker_ids;
  cv::aruco::CharucoDetector(*board).detectBoard(image, pixels, ids, known, known_ids);
}

#else

Dictionary OpenDictionary(int number) { return *cv::aruco::getPredefinedDictionary(number); }

cv::Ptr<CharucoBoard> MakeCharuco(cv::Size squares, double square, double marker,
                                  const Dictionary& dictionary) {
  return CharucoBoard::create(squares.width, squares.height, static_cast<float>(square),
                              static_cast<float>(marker), cv::makePtr<Dictionary>(dictionary));
}

const Dictionary& DictionaryOf(const CharucoBoard& board) { return *board.dictionary; }

const std::vector<std::vector<cv::Point3f>>& MarkersOf(const CharucoBoard& board) {
  return board.objPoints;
}

cv::Mat1b Draw(const cv::Ptr<CharucoBoard>& board, cv::Size size) {
  cv::Mat1b picture;
  board->draw(size, picture, 0, 1);
  return picture;
}

cv::Mat1b DrawMarker(const Dictionary& dictionary, int id, int side, int border_bits) {
  cv::Mat1b picture;
  cv::aruco::drawMarker(cv::makePtr<Dictionary>(dictionary), id, side, picture, border_bits);
  return picture;
}

void FindMarkers(const cv::Mat1b& image, const Dictionary& dictionary, std::vector<Quad>& markers,
                 std::vector<int>& ids, int border_bits) {
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = border_bits;
  cv::aruco::detectMarkers(image, cv::makePtr<Dictionary>(dictionary), markers, ids, parameters);
}

void FindCorners(const cv::Mat1b& image, const cv::Ptr<CharucoBoard>& board,
                 const std::vector<Quad>& markers, const std::vector<int>& marker_ids,
                 std::vector<cv::Point2f>& pixels, std::vector<int>& ids) {
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, image, board, pixels, ids);
}

#endif

}  // namespace sprout::calibrate::aruco
