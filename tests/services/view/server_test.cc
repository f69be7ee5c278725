#include "services/view/server.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <list>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/config/config_error.h"
#include "tests/common/testing/thrown.h"
#include "tests/services/view/view_frames.h"

namespace sprout::view {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

using Page = beast::websocket::stream<tcp::socket>;

class ServerTest : public ::testing::Test {
 protected:
  ServerTest() { AddWhole(input_, 0); }

  tcp::socket Connect() {
    tcp::socket socket(io_);
    socket.connect({asio::ip::address_v4::loopback(), server_.port()});
    // A test that waits in vain should fail, not hang.
    const timeval patience{.tv_sec = 20, .tv_usec = 0};
    setsockopt(socket.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    return socket;
  }

  // Sends bytes and reads until the server hangs up.
  std::string Ask(const std::string& bytes) {
    tcp::socket socket = Connect();
    boost::system::error_code error;
    asio::write(socket, asio::buffer(bytes), error);
    std::string answer;
    asio::read(socket, asio::dynamic_buffer(answer), error);
    return answer;
  }

  Page Open(const std::string& origin = "") {
    Page page(Connect());
    const std::string host = "127.0.0.1:" + std::to_string(server_.port());
    page.set_option(
        beast::websocket::stream_base::decorator([&](beast::websocket::request_type& request) {
          if (!origin.empty()) request.set(beast::http::field::origin, origin);
        }));
    page.handshake(host, "/ws");
    return page;
  }

  // Pages that were hung up on take a moment to go, and the server takes no more than so many.
  Page OpenWhenThereIsRoom() {
    while (true) {
      try {
        return Open();
      } catch (const boost::system::system_error&) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
    }
  }

  // The next frame, without statuses.
  static int64_t ReadFrame(Page& page) {
    while (true) {
      beast::flat_buffer buffer;
      page.read(buffer);
      if (page.got_text()) continue;
      const std::string bytes = beast::buffers_to_string(buffer.data());
      const size_t place = bytes.find("\"seq\":");
      return std::stoll(bytes.substr(place + 6));
    }
  }

  static nlohmann::json ReadText(Page& page, const std::string& type) {
    while (true) {
      beast::flat_buffer buffer;
      page.read(buffer);
      if (!page.got_text()) continue;
      auto message = nlohmann::json::parse(beast::buffers_to_string(buffer.data()));
      if (message["type"] == type) return message;
    }
  }

  static void Say(Page& page, const std::string& text) { page.write(asio::buffer(text)); }

  RingInput input_;
  FrameEncoder encoder_{[](Part, const std::string& why) { ADD_FAILURE() << why; }};
  HttpHandler handler_{input_.ring, encoder_, &input_.ring, nullptr, ""};
  Server server_{"127.0.0.1",
                 0,
                 {.source = &input_.ring,
                  .encoder = &encoder_,
                  .handler = &handler_,
                  .hello = [] { return R"({"type":"hello"})"; },
                  .status = [] { return R"({"type":"status"})"; },
                  .keep_bytes = 1 << 20}};
  asio::io_context io_;
};

constexpr char kWish[] = R"({"type":"wish","pictures":{"left":64,"disparity":64},"cloud":true})";
// What a page asks whose WebSocket was refused.
constexpr char kRoom[] = "GET /ws HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
constexpr char kDrawn[] = R"({"type":"drawn"})";

TEST_F(ServerTest, AnswersRequestsOnOneConnectionAfterAnother) {
  const std::string request = "GET /style.css HTTP/1.1\r\nHost: localhost\r\n";
  const std::string answer = Ask(request + "\r\n" + request + "Connection: close\r\n\r\n");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_NE(answer.find("HTTP/1.1 200", 10), std::string::npos);
  EXPECT_THAT(answer, HasSubstr("Content-Security-Policy: default-src 'none'"));
  EXPECT_THAT(Ask("GET /save?key=0&what=disparity.pfm HTTP/1.1\r\nHost: localhost\r\n"
                  "Connection: close\r\n\r\n"),
              HasSubstr("filename=\"000000_disparity.pfm\""));
}

TEST_F(ServerTest, RefusesWhatIsTooLargeOrNoRequest) {
  const std::string huge =
      "GET /" + std::string(100'000, 'a') + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  EXPECT_THAT(Ask(huge), ::testing::AnyOf(StartsWith("HTTP/1.1 413"), ""));
  EXPECT_THAT(Ask("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 999999999\r\n\r\n"),
              StartsWith("HTTP/1.1 413"));
  EXPECT_EQ(Ask("\x16\x03\x01\r\n\r\n"), "");  // TLS
  EXPECT_THAT(Ask("GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 403"));
}

TEST_F(ServerTest, SendsAFrameOnlyAfterTheLastIsDrawn) {
  Page page = Open();
  Say(page, kWish);
  EXPECT_EQ(ReadFrame(page), 0);
  for (int64_t seq = 1; seq <= 20; ++seq) {
    AddWhole(input_, seq);
    server_.FrameChanged();
  }
  Say(page, kDrawn);
  EXPECT_EQ(ReadFrame(page), 20);
  Say(page, R"({"type":"look","key":5})");
  Say(page, kDrawn);
  EXPECT_EQ(ReadFrame(page), 5);
  Say(page, R"({"type":"probe","u":40,"v":20})");
  EXPECT_EQ(ReadText(page, "probe")["disparity_px"], 10);
  Say(page, R"({"type":"measure"})");
  EXPECT_EQ(ReadText(page, "measure")["region"], nlohmann::json({16, 12, 32, 24}));
  Say(page, R"({"type":"look","key":500})");
  Say(page, kDrawn);
  EXPECT_EQ(ReadText(page, "gone")["key"], 500);
}

TEST_F(ServerTest, HangsUpOnWhoIsNoPageOfItsOwn) {
  Page page = Open();
  Say(page, R"({"type":"format"})");
  boost::system::error_code error;
  for (beast::flat_buffer buffer; !error; buffer.clear()) page.read(buffer, error);
  EXPECT_NE(error, boost::system::error_code());
  EXPECT_THROW(Open("http://evil.example"), std::exception);
  EXPECT_NO_THROW(Open("http://127.0.0.1:" + std::to_string(server_.port())));
}

TEST_F(ServerTest, ServesOthersWhileOneNeverReads) {
  Page deaf = Open();
  Say(deaf, kWish);
  Page page = Open();
  Say(page, kWish);
  for (int64_t seq = 1; seq < 40; ++seq) {
    EXPECT_GE(ReadFrame(page), seq - 1);
    AddWhole(input_, seq);
    server_.FrameChanged();
    Say(page, kDrawn);
    // Pretends to have drawn, and reads nothing.
    Say(deaf, kDrawn);
  }
}

TEST_F(ServerTest, Holds50ConnectionsAnd16PagesAndStillAnswers) {
  std::list<tcp::socket> idle;
  for (int i = 0; i < 50; ++i) idle.push_back(Connect());
  std::list<Page> pages;
  for (int i = 0; i < Server::kMaxPages; ++i) {
    pages.push_back(Open());
    Say(pages.back(), kWish);
  }
  EXPECT_THROW(Open(), std::exception);
  EXPECT_THAT(Ask(kRoom), AllOf(StartsWith("HTTP/1.1 503"), HasSubstr("too many pages are open")));
  for (Page& page : pages) EXPECT_EQ(ReadFrame(page), 0);
  EXPECT_THAT(Ask("GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 200"));
  // Closed connections make room for others.
  pages.clear();
  const auto opens = [&] {
    try {
      Open();
      return true;
    } catch (const std::exception&) {
      return false;
    }
  };
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  bool open = opens();
  while (!open && std::chrono::steady_clock::now() < deadline) open = opens();
  EXPECT_TRUE(open);
  EXPECT_THAT(Ask(kRoom), StartsWith("HTTP/1.1 200"));
}

// A client that asks for a log and never reads it holds it until the server's timeout.
TEST_F(ServerTest, HoldsOneCopyOfALogForManyWhoNeverRead) {
  // More than a socket takes.
  for (int64_t seq = 1; seq <= 16; ++seq) {
    input_.Add(seq, Part::kLeft, cv::Mat(1024, 1024, CV_8UC1, cv::Scalar(7)));
  }
  const std::string request = "GET /save-log?seconds=100 HTTP/1.1\r\nHost: localhost\r\n\r\n";
  std::list<tcp::socket> readers;
  int given = 0;
  int refused = 0;
  for (int i = 0; i < 60; ++i) {
    readers.push_back(Connect());
    asio::write(readers.back(), asio::buffer(request));
    std::array<char, 12> status{};
    asio::read(readers.back(), asio::buffer(status));
    const std::string_view text(status.data(), status.size());
    given += text == "HTTP/1.1 200" ? 1 : 0;
    refused += text == "HTTP/1.1 503" ? 1 : 0;
  }
  EXPECT_EQ(given, 2);
  EXPECT_EQ(refused, 58);
  // A closed connection makes room for others.
  readers.clear();
  std::string answer;
  for (int i = 0; i < 200 && !answer.starts_with("HTTP/1.1 200"); ++i) {
    answer =
        Ask("GET /save-log?seconds=1 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  }
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
}

TEST_F(ServerTest, RefusesALogToAPageFromElsewhere) {
  const std::string request =
      "GET /save-log?seconds=1 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n";
  EXPECT_THAT(Ask(request + "\r\n"), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(Ask(request + "Sec-Fetch-Site: cross-site\r\n\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(Ask(request + "Origin: http://evil.example\r\n\r\n"), StartsWith("HTTP/1.1 403"));
}

TEST_F(ServerTest, LogsBadPagesOnceASecond) {
  ::testing::internal::CaptureStdout();  // where log lines go by default
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 50; ++i) {
    Page page = OpenWhenThereIsRoom();
    Say(page, R"({"type":"format"})");
    boost::system::error_code error;
    for (beast::flat_buffer buffer; !error; buffer.clear()) page.read(buffer, error);
  }
  const auto seconds =
      std::chrono::ceil<std::chrono::seconds>(std::chrono::steady_clock::now() - begin);
  const std::string text = ::testing::internal::GetCapturedStdout();
  EXPECT_THAT(text, HasSubstr("a page sent a message of an unknown type; it is hung up on"));
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), seconds.count());
}

TEST_F(ServerTest, SaysThatItsPortIsTaken) {
  EXPECT_THAT(Thrown<ConfigError>([&] { const Server second("127.0.0.1", server_.port(), {}); }),
              HasSubstr("Address already in use; is another sprout-view running?"));
  EXPECT_THROW(Server("localhost", 0, {}), ConfigError);
}

}  // namespace
}  // namespace sprout::view
