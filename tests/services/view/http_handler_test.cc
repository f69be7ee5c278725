#include "services/view/http_handler.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <optional>

#include "tests/services/view/view_frames.h"

namespace sprout::view {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class HttpHandlerTest : public ::testing::Test {
 protected:
  HttpHandlerTest() {
    for (int64_t seq = 0; seq < 3; ++seq) AddWhole(input_, seq);
  }

  HttpReply Get(std::string_view target, std::string_view host = "127.0.0.1:8420") const {
    return handler_.Handle({.method = "GET", .target = target, .host = host, .origin = {}});
  }

  HttpReply GetFrom(std::string_view target, std::string_view site, std::string_view origin) const {
    return handler_.Handle({.method = "GET",
                            .target = target,
                            .host = "127.0.0.1:8420",
                            .origin = origin,
                            .fetch_site = site});
  }

  static std::string Text(const HttpReply& reply) {
    if (!reply.file) return reply.body;
    const int descriptor = reply.file->OpenForReading();
    struct stat status {};
    fstat(descriptor, &status);
    std::string text(static_cast<size_t>(status.st_size), '\0');
    EXPECT_EQ(read(descriptor, text.data(), text.size()), status.st_size);
    close(descriptor);
    return text;
  }

  RingInput input_;
  FrameEncoder encoder_{[](Part, const std::string& why) { ADD_FAILURE() << why; }};
  HttpHandler handler_{input_.ring, encoder_, &input_.ring, nullptr, "A_"};
};

TEST_F(HttpHandlerTest, GivesThePageAndWhatItAsksFor) {
  EXPECT_THAT(Get("/").body, StartsWith("<!doctype html>"));
  EXPECT_EQ(Get("/").type, "text/html; charset=utf-8");
  for (const PageFile& file : PageFiles()) {
    EXPECT_EQ(Get(file.path).status, 200) << file.path;
    EXPECT_EQ(Get(file.path).body, file.bytes);
    EXPECT_GT(file.bytes.size(), 100U) << file.path;
    // Nothing comes from anywhere else, see also the Content-Security-Policy.
    if (!file.path.starts_with("/lib/")) {
      EXPECT_THAT(std::string(file.bytes), ::testing::Not(HasSubstr("https://")));
    }
  }
}

TEST_F(HttpHandlerTest, HasNoOtherFiles) {
  for (const char* target : {"/etc/passwd", "/../../etc/passwd", "//etc/passwd", "/%2e%2e/main.cc",
                             "/index.html/", "index.html", "", "*", "/page/app.js", "/lib/"}) {
    EXPECT_EQ(Get(target).status, 404) << target;
  }
}

TEST_F(HttpHandlerTest, ServesOnlyWhoCallsItByItsOwnName) {
  for (const char* host :
       {"localhost", "localhost:8420", "127.0.0.1", "[::1]:8420", "10.0.0.7:80"}) {
    EXPECT_EQ(Get("/", host).status, 200) << host;
  }
  for (const char* host :
       {"", "evil.example", "evil.example:8420", "127.0.0.1.evil.example", "localhost.evil.example",
        "[", "[]", "[::1]8420", "localhost:84a20", "127.0.0.1:8420; script-src *"}) {
    EXPECT_EQ(Get("/", host).status, 403) << host;
  }
}

TEST_F(HttpHandlerTest, TakesGetAlone) {
  for (const char* method : {"POST", "PUT", "DELETE", "HEAD", "", "GETGET"}) {
    EXPECT_EQ(handler_.Handle({.method = method, .target = "/", .host = "localhost", .origin = {}})
                  .status,
              405);
  }
}

TEST_F(HttpHandlerTest, SavesAFrame) {
  EXPECT_THAT(Text(Get("/save?key=1&what=left.png")), StartsWith("\x89PNG"));
  EXPECT_THAT(Text(Get("/save?key=1&what=disparity.png")), StartsWith("\x89PNG"));
  EXPECT_THAT(Text(Get("/save?key=1&what=disparity.pfm")), StartsWith("Pf\n64 48\n"));
  const HttpReply cloud = Get("/save?key=1&what=cloud.ply");
  EXPECT_THAT(Text(cloud), StartsWith("ply\n"));
  EXPECT_EQ(cloud.file_name, "000001_cloud.ply");
}

TEST_F(HttpHandlerTest, SaysWhatCannotBeSaved) {
  EXPECT_EQ(Get("/save?key=77&what=left.png").status, 404);
  EXPECT_EQ(Get("/save?key=1&what=prior.pfm").body, "the frame has no such map\n");
  EXPECT_EQ(Get("/save?key=1&what=sigma.pfm").body, "the frame has no standard deviations\n");
  EXPECT_THAT(Get("/save?key=1&what=../x").body, StartsWith("what: allowed are"));
  for (const char* target :
       {"/save", "/save?key=1", "/save?key=x&what=left.png", "/save?key=-1&what=left.png",
        "/save?key=99999999999999999999&what=a", "/thumb", "/thumb?key=", "/save-log",
        "/save-log?seconds=0", "/save-log?seconds=1e9"}) {
    EXPECT_EQ(Get(target).status, 400) << target;
  }
}

TEST_F(HttpHandlerTest, SavesTheLastSeconds) {
  const HttpReply log = Get("/save-log?seconds=10");
  EXPECT_EQ(log.file_name, "sprout.lcm");
  EXPECT_THAT(Text(log), StartsWith("\xED\xA1\xDA\x01"));
  EXPECT_THAT(Text(log), HasSubstr("A_SPROUT_DISPARITY"));
}

TEST_F(HttpHandlerTest, GivesOneCopyOfALogToTwoReadersAndNoneToAThird) {
  auto first = std::make_optional(Get("/save-log?seconds=10"));
  auto second = std::make_optional(Get("/save-log?seconds=10"));
  EXPECT_EQ(first->status, 200);
  EXPECT_EQ(first->file, second->file);
  EXPECT_EQ(Get("/save-log?seconds=10").status, 503);
  EXPECT_EQ(Get("/save-log?seconds=10").body,
            "a log is being saved already: try again in a moment\n");
  EXPECT_EQ(Get("/save?key=1&what=left.png").status, 200);
  second.reset();
  EXPECT_EQ(Get("/save-log?seconds=11").status, 503);  // would be a second copy
  first.reset();
  EXPECT_EQ(Get("/save-log?seconds=11").status, 200);
}

TEST_F(HttpHandlerTest, HoldsTwoSavedFramesAtATime) {
  const HttpReply first = Get("/save?key=1&what=left.png");
  const HttpReply second = Get("/save?key=1&what=disparity.pfm");
  EXPECT_THAT(Text(first), StartsWith("\x89PNG"));
  EXPECT_THAT(Text(second), StartsWith("Pf\n64 48\n"));
  EXPECT_EQ(Get("/save?key=1&what=cloud.ply").status, 503);
  EXPECT_EQ(Get("/save-log?seconds=10").status, 200);
}

TEST(SharedFiles, GivesNobodyALogThatIsOld) {
  SharedFiles files(2);
  const auto write = [](const std::filesystem::path&) -> Result<void> { return {}; };
  const SharedFiles::Clock::time_point now{};
  const SharedFiles::File file = *files.Take("10", now, write);
  EXPECT_EQ(*files.Take("10", now + SharedFiles::kFresh, write), file);
  EXPECT_NE(*files.Take("10", now + SharedFiles::kFresh + std::chrono::seconds(1), write), file);
}

// A picture in a page of another site makes the browser send such a request.
TEST_F(HttpHandlerTest, DoesNothingForPagesFromElsewhere) {
  for (const char* target : {"/save-log?seconds=10", "/save?key=1&what=cloud.ply", "/thumb?key=1",
                             "/timeline?buckets=10", "/no-such"}) {
    for (const char* site : {"cross-site", "same-site", "nonsense"}) {
      EXPECT_EQ(GetFrom(target, site, "").status, 403) << target << " " << site;
    }
    for (const char* origin :
         {"http://evil.example", "null", "https://127.0.0.1:8420", "http://127.0.0.1:8421"}) {
      EXPECT_EQ(GetFrom(target, "", origin).status, 403) << target << " " << origin;
    }
    for (const char* site : {"same-origin", "none", ""}) {
      EXPECT_NE(GetFrom(target, site, "").status, 403) << target << " " << site;
      EXPECT_NE(GetFrom(target, site, "http://127.0.0.1:8420").status, 403) << target;
    }
  }
  // A link to the page is allowed.
  EXPECT_EQ(GetFrom("/", "cross-site", "").status, 200);
  EXPECT_EQ(GetFrom("/app.js", "cross-site", "").status, 200);
}

TEST_F(HttpHandlerTest, HasThumbnails) {
  const HttpReply thumbnail = Get("/thumb?key=2");
  EXPECT_EQ(thumbnail.type, "image/jpeg");
  EXPECT_THAT(thumbnail.body, StartsWith("\xFF\xD8"));
  EXPECT_EQ(Get("/thumb?key=3").status, 404);
  EXPECT_EQ(Get("/timeline?buckets=10").status, 404);  // no log
}

}  // namespace
}  // namespace sprout::view
