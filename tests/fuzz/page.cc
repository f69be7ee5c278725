// What a browser sends to sprout-view.
#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <string>

#include "services/view/http_connection.h"
#include "services/view/http_handler.h"
#include "services/view/view_session.h"
#include "tests/fuzz/targets.h"
#include "tests/services/view/view_frames.h"

namespace sprout::fuzz {
namespace {

namespace http = boost::beast::http;

constexpr int64_t kFrames = 2;

// A viewer of a graph that gave two frames.
struct Viewer {
  Viewer() {
    for (int64_t seq = 0; seq < kFrames; ++seq) view::AddWhole(input, seq);
  }

  view::RingInput input;
  view::FrameEncoder encoder{[](Part, const std::string& why) { Check(false, "encoder: " + why); }};
  view::HttpHandler handler{input.ring, encoder, &input.ring, nullptr, ""};
};

Viewer& TheViewer() {
  static Viewer viewer;
  return viewer;
}

bool IsHarmlessInHeader(std::string_view text) {
  return std::ranges::none_of(text, [](unsigned char c) {
    return c <= ' ' || c >= 0x7f || c == ';' || c == ',' || c == '"' || c == '\'';
  });
}

Bytes Request(const std::string& target, const std::string& host) {
  return BytesOf("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\nOrigin: http://" + host +
                 "\r\n\r\n");
}

}  // namespace

void AnswerHttp(std::span<const uint8_t> bytes) {
  http::request_parser<http::empty_body> parser;
  parser.header_limit(8192);
  parser.body_limit(0);
  boost::system::error_code error;
  parser.put(boost::asio::buffer(bytes.data(), bytes.size()), error);
  if (error || !parser.is_done()) return;
  const view::HttpRequest request = view::ViewOf(parser.get());
  const view::HttpReply reply = TheViewer().handler.Handle(request);
  Check(reply.status >= 200 && reply.status < 600, "a status that HTTP does not have");
  Check(IsHarmlessInHeader(reply.file_name), "a file's name with more than a name");
  const bool is_own = view::IsOwnHost(request.host);
  Check(!is_own || IsHarmlessInHeader(request.host), "a host with more than a name and a port");
  Check(is_own || reply.status == 403, "another host's page got an answer");
  if (view::IsOwnOrigin(request.origin, request.host)) {
    Check(request.origin.empty() || request.origin.ends_with(request.host), "a foreign origin");
  }
}

std::vector<Bytes> HttpSeeds() {
  return {Request("/", "127.0.0.1:8420"),
          Request("/thumb?key=1", "[::1]:8420"),
          Request("/save?key=0&what=disparity.pfm", "localhost"),
          Request("/save?key=1&what=cloud.ply", "localhost:1"),
          Request("/save-log?seconds=5", "10.0.0.1"),
          Request("/timeline?buckets=10", "127.0.0.1"),
          Request("/../../etc/passwd", "evil.example"),
          BytesOf("POST /save HTTP/1.0\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n")};
}

// A line a message; between them the page gets what it may see.
void AnswerPage(std::span<const uint8_t> bytes) {
  Viewer& viewer = TheViewer();
  view::PausedFrameBudget budget(size_t{1} << 20);
  view::ViewSession session(viewer.input.ring, budget);
  std::string_view rest(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  while (!rest.empty()) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    if (!session.OnMessage(rest.substr(0, end))) return;  // the page is hung up on
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (const auto show = session.TakeFrame()) {
      Check(show->frame->key >= 0 && show->frame->key < kFrames, "a frame that never was");
      Check(!viewer.encoder.Encode(show->frame, show->parts, session.keys()).empty(), "no packet");
    }
    if (const auto probe = session.TakeProbe()) {
      viewer.encoder.Probe(probe->frame, probe->u, probe->v);
    }
  }
}

std::vector<Bytes> PageSeeds() {
  const std::string wish =
      R"({"type":"wish","pictures":{"left":640,"disparity":32,"depth":64},"cloud":true,"seeds":true})";
  return {
      BytesOf(wish + "\n" + R"({"type":"drawn"})" + "\n" + R"({"type":"probe","u":5,"v":7})"),
      BytesOf(wish + "\n" + R"({"type":"pause"})" + "\n" + R"({"type":"look","key":0})" + "\n" +
              R"({"type":"drawn"})" + "\n" + R"({"type":"live"})"),
      BytesOf(R"({"type":"look","key":9223372036854775807})"),
      BytesOf(R"({"type":"wish","pictures":{"tof":1,"prior":5000,"sigma":16,"confidence":20}})")};
}

}  // namespace sprout::fuzz
