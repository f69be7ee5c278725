#include "services/view/page_connection.h"

#include <boost/asio/post.hpp>
#include <chrono>
#include <exception>
#include <utility>

#include "services/view/packet.h"

namespace sprout::view {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

constexpr size_t kMaxWishBytes = 4096;

// A page that neither receives nor sends anything for so long counts as closed.
constexpr std::chrono::seconds kIdleTime{60};

}  // namespace

PageConnection::PageConnection(ServerState& state, ConnectionCount count,
                               boost::asio::ip::tcp::socket socket)
    : state_(state),
      count_(std::move(count)),
      session_(*state.parts.source, state.budget),
      stream_(std::move(socket)) {
  state_.pages.insert(this);
  stream_.set_option(websocket::stream_base::timeout{.handshake_timeout = std::chrono::seconds(10),
                                                     .idle_timeout = kIdleTime,
                                                     .keep_alive_pings = true});
  stream_.read_message_max(kMaxWishBytes);
  stream_.auto_fragment(false);
}

PageConnection::~PageConnection() { state_.pages.erase(this); }

void PageConnection::Accept(beast::http::request<beast::http::empty_body> request) {
  auto asked = std::make_shared<decltype(request)>(std::move(request));
  stream_.async_accept(*asked, [self = shared_from_this(), asked](beast::error_code error) {
    if (error) return;
    self->open_ = true;
    self->Send({self->state_.parts.hello(), true, false});
    self->Send({self->state_.parts.status(), true, false});
    self->Read();
  });
}

void PageConnection::Read() {
  stream_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, size_t) {
    self->OnRead(error);
  });
}

void PageConnection::OnRead(beast::error_code error) {
  if (error) {
    open_ = false;
    return;
  }
  const auto data = buffer_.cdata();
  const Result<void> understood =
      session_.OnMessage({static_cast<const char*>(data.data()), data.size()});
  buffer_.consume(buffer_.size());
  if (!understood) {
    state_.bad_pages.Warn("a page sent " + understood.error().text + "; it is hung up on");
    open_ = false;
    beast::error_code ignored;
    beast::get_lowest_layer(stream_).socket().close(ignored);
    return;
  }
  Pump();
  Read();
}

// The connection is returned to the thread of the sockets, which alone may destroy it.
template <typename Work>
void PageConnection::SendLater(Work work, bool is_text, bool PageConnection::*busy) {
  this->*busy = true;
  auto make = [self = shared_from_this(), work = std::move(work), is_text, busy]() mutable {
    auto message = std::make_shared<Message>(Message{{}, is_text, false});
    try {
      message->bytes = work();
    } catch (const std::exception& e) {  // out of memory
      message->bytes = JsonText({{"type", "error"}, {"text", e.what()}});
      message->is_text = true;
    }
    PageConnection& page = *self;
    boost::asio::post(page.stream_.get_executor(), [self = std::move(self), message, busy] {
      (*self).*busy = false;
      self->Send(std::move(*message));
    });
  };
  boost::asio::post(state_.pictures, std::move(make));
}

void PageConnection::Pump() {
  if (!open_ || !outbox_.empty()) return;
  FrameEncoder& encoder = *state_.parts.encoder;
  const auto answer_later = [this](const char* type, auto answer, bool PageConnection::*busy) {
    const auto text = [type, answer = std::move(answer)] {
      nlohmann::json json = answer();
      json["type"] = type;
      return JsonText(json);
    };
    SendLater(text, /*is_text=*/true, busy);
  };
  if (auto probe = probing_ ? std::nullopt : session_.TakeProbe()) {
    const auto answer = [&encoder, probe = std::move(*probe)] {
      return encoder.Probe(probe.frame, probe.u, probe.v);
    };
    answer_later("probe", answer, &PageConnection::probing_);
  }
  if (auto measure = measuring_ ? std::nullopt : session_.TakeMeasure()) {
    // The panel is used on the thread of the pictures only.
    const auto answer = [&encoder, measure = std::move(*measure)] {
      return measure.panel->Show(*encoder.Decode(measure.frame));
    };
    answer_later("measure", answer, &PageConnection::measuring_);
  }
  if (encoding_) return;
  if (auto show = session_.TakeFrame()) {
    const KeyRange keys = session_.keys();
    SendLater([&encoder, show = std::move(*show),
               keys] { return encoder.Encode(show.frame, show.parts, keys); },
              /*is_text=*/false, &PageConnection::encoding_);
  }
  if (const auto gone = session_.TakeGone()) {
    Send({JsonText({{"type", "gone"}, {"key", *gone}}), true, false});
  }
}

void PageConnection::SendStatus(const std::string& status) {
  if (!open_ || status_waits_) return;
  status_waits_ = true;
  Send({status, true, true});
}

void PageConnection::Send(Message message) {
  if (!open_) return;
  outbox_.push_back(std::move(message));
  if (outbox_.size() == 1) Write();
}

void PageConnection::Write() {
  const Message& message = outbox_.front();
  stream_.text(message.is_text);
  stream_.async_write(boost::asio::buffer(message.bytes),
                      [self = shared_from_this()](beast::error_code error, size_t) {
                        if (error) {
                          self->open_ = false;
                          return;
                        }
                        if (self->outbox_.front().is_status) self->status_waits_ = false;
                        self->outbox_.pop_front();
                        self->outbox_.empty() ? self->Pump() : self->Write();
                      });
}

void ServePage(ServerState& state, ConnectionCount count, boost::asio::ip::tcp::socket socket,
               beast::http::request<beast::http::empty_body> request) {
  std::make_shared<PageConnection>(state, std::move(count), std::move(socket))
      ->Accept(std::move(request));
}

}  // namespace sprout::view
