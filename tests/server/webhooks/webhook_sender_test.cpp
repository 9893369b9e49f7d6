// Webhooks as their receivers see them.
#include "server/webhooks/webhook_sender.h"

#include <deque>

#include "core/base/file.h"
#include "tests/server/test_service.h"

namespace qray::server {
namespace {

using test::Json;
using test::TestService;

// Takes what is sent, and answers as it is told: first these, then 204.
class Receiver {
 public:
  explicit Receiver(std::deque<int> answers = {},
                    std::unique_ptr<httplib::Server> server = std::make_unique<httplib::Server>())
      : server_(std::move(server)), answers_(std::move(answers)) {
    server_->Post(".*", [this](const httplib::Request& req, httplib::Response& res) {
      std::lock_guard lock(mutex_);
      got_.push_back(req);
      res.status = 204;
      if (answers_.empty()) return;
      res.status = answers_.front();
      answers_.pop_front();
      if (res.status / 100 == 3) res.set_header("Location", "/elsewhere");
    });
    port_ = server_->bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_->listen_after_bind(); });
    // A stop before it listens would be lost.
    while (!server_->is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ~Receiver() {
    server_->stop();
    thread_.join();
  }
  std::string url(const std::string& origin = "http://127.0.0.1") const {
    return origin + ":" + std::to_string(port_) + "/hook?a=b";
  }
  std::vector<httplib::Request> wait(size_t count) const {
    for (int i = 0; i < 4000; ++i) {
      {
        std::lock_guard lock(mutex_);
        if (got_.size() >= count) return got_;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << "expected " << count << " requests";
    return {};
  }
  size_t count() const {
    std::lock_guard lock(mutex_);
    return got_.size();
  }

 private:
  std::unique_ptr<httplib::Server> server_;
  mutable std::mutex mutex_;
  std::vector<httplib::Request> got_;
  std::deque<int> answers_;
  int port_ = 0;
  std::thread thread_;
};

// Speaks TLS with a certificate of its own for `name` ("DNS:localhost"), left in `folder`.
std::unique_ptr<httplib::Server> tls_server(const std::filesystem::path& folder,
                                            const std::string& name) {
  std::filesystem::create_directories(folder);
  const std::string key = folder / "key.pem", certificate = folder / "certificate.pem";
  const std::string make =
      "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1"
      " -nodes -days 1 -subj /CN=qray -addext subjectAltName=" +
      name + " -keyout " + key + " -out " + certificate + " 2> /dev/null";
  EXPECT_EQ(std::system(make.c_str()), 0) << make;
  return std::make_unique<httplib::SSLServer>(certificate.c_str(), key.c_str());
}

class Webhooks : public ::testing::Test {
 protected:
  void start(bool private_addresses) {
    s_.config.private_webhooks = private_addresses;
    s_.start();
  }
  Json add(const std::string& url, int status = 201) const {
    return s_.post("/v1/webhooks", Json{{"url", url}}.dump(), status);
  }
  std::string run() const {
    const std::string id = s_.submit(
        {{"scene", "box"}, {"width", 16}, {"height", 16}, {"method", "none"}, {"samples", 1}});
    s_.wait_end(id);
    return id;
  }
  Json listed() const { return s_.get("/v1/webhooks")["webhooks"]; }
  Json wait_listed(const std::function<bool(const Json&)>& until) const {
    Json all;
    for (int i = 0; i < 2000; ++i) {
      all = listed();
      if (until(all)) return all;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << all.dump();
    return all;
  }
  TestService s_;
};

TEST_F(Webhooks, AreToldOfEndsAndKnowWhoSpeaks) {
  const Receiver receiver;
  start(true);
  const Json made = add(receiver.url());
  const std::string secret = made["secret"], id = made["id"];
  EXPECT_EQ(secret.size(), 64u);
  EXPECT_FALSE(listed()[0].contains("secret"));
  const std::string first = run(), second = run();
  const auto got = receiver.wait(2);
  for (size_t i = 0; i < 2; ++i) {
    const httplib::Request& req = got.at(i);
    const Json body = Json::parse(req.body);
    EXPECT_EQ(body["event"], "job.ended");
    EXPECT_EQ(body["job"]["id"], i == 0 ? first : second);
    EXPECT_EQ(body["job"]["state"], "succeeded");
    EXPECT_EQ(req.target, "/hook?a=b");
    EXPECT_EQ(req.get_header_value("Content-Type"), "application/json");
    const std::string signature = req.get_header_value("Qray-Signature");
    const int64_t seconds = std::atoll(signature.c_str() + 2);
    EXPECT_LT(std::abs(std::time(nullptr) - seconds), 60);
    EXPECT_EQ(signature, "t=" + std::to_string(seconds) +
                             ",v1=" + webhook_signature(secret, seconds, req.body));
  }
  EXPECT_NE(got[0].get_header_value("Qray-Delivery"), got[1].get_header_value("Qray-Delivery"));
  wait_listed([](const Json& all) { return all[0]["waiting"] == 0; });
  EXPECT_EQ(s_.client().Delete("/v1/webhooks/" + id)->status, 204);
  EXPECT_EQ(s_.client().Delete("/v1/webhooks/" + id)->status, 404);
  run();
  EXPECT_EQ(receiver.count(), 2u);
}

TEST(WebhookSignature, IsAnHmac) {
  EXPECT_EQ(webhook_signature("Jefe", 1, "what do ya want for nothing?").size(), 64u);
  EXPECT_NE(webhook_signature("Jefe", 1, "x"), webhook_signature("Jefe", 2, "x"));
  EXPECT_NE(webhook_signature("Jefe", 1, "x"), webhook_signature("jefe", 1, "x"));
  // As `printf 1.x | openssl dgst -sha256 -hmac Jefe` has it.
  EXPECT_EQ(webhook_signature("Jefe", 1, "x"),
            "2f7ccbd0f043456ad29514b2d24a8aa345ec6673a5db1b44e91c8ac99d1841e3");
}

TEST_F(Webhooks, WhatWasNotTakenComesAgainInOrder) {
  const Receiver receiver({302});
  start(true);
  add(receiver.url());
  const std::string first = run(), second = run();
  const auto got = receiver.wait(3);
  std::vector<std::string> jobs;
  for (const httplib::Request& req : got) jobs.push_back(Json::parse(req.body)["job"]["id"]);
  EXPECT_EQ(jobs, (std::vector{first, first, second}));
  EXPECT_EQ(got[0].get_header_value("Qray-Delivery"), got[1].get_header_value("Qray-Delivery"));
  EXPECT_EQ(got[1].target, "/hook?a=b");  // not where it was redirected
  wait_listed([](const Json& all) { return all[0]["waiting"] == 0 && all[0]["failures"] == 0; });
}

TEST_F(Webhooks, OneThatFailsHoldsUpNoOtherAndIsToldAfterARestart) {
  start(true);
  std::string url;
  {
    const Receiver gone;
    url = gone.url();
  }
  const Receiver receiver;
  add(url);
  add(receiver.url());
  run();
  receiver.wait(1);
  wait_listed([](const Json& all) { return all[0]["failures"].get<int>() > 0; });
  EXPECT_EQ(listed()[0]["waiting"], 1);
  s_.stop();
  s_.start();
  EXPECT_EQ(listed()[0]["waiting"], 1);
  EXPECT_EQ(receiver.count(), 1u);
}

TEST_F(Webhooks, PrivateAddressesGetNothing) {
  const Receiver receiver;
  start(false);
  add(receiver.url());
  add("http://localhost:" + receiver.url().substr(17, 5) + "/");
  run();
  wait_listed([](const Json& all) {
    return all[0]["failures"].get<int>() > 0 && all[1]["failures"].get<int>() > 0;
  });
  EXPECT_EQ(receiver.count(), 0u);
}

TEST_F(Webhooks, ByTlsTheCertificateMustBeKnownAndTheHosts) {
  const qray::test::ScratchFolder scratch;
  const Receiver named({}, tls_server(scratch / "named", "DNS:localhost"));
  const Receiver numbered({}, tls_server(scratch / "numbered", "IP:127.0.0.1"));
  const Receiver of_another({}, tls_server(scratch / "of_another", "DNS:example.org"));
  const Receiver unknown({}, tls_server(scratch / "unknown", "DNS:localhost"));
  std::string trusted;
  for (const char* server : {"named", "numbered", "of_another"}) {
    const Result<Bytes> bytes = read_file(scratch / server / "certificate.pem", 1 << 16);
    ASSERT_TRUE(bytes.ok()) << bytes.error().text();
    trusted.append(bytes.value().begin(), bytes.value().end());
  }
  test::write_text(scratch / "trusted.pem", trusted);
  ::setenv("SSL_CERT_FILE", (scratch / "trusted.pem").c_str(), 1);
  start(true);
  add(named.url("https://localhost"));
  add(numbered.url("https://127.0.0.1"));
  for (const Receiver* refused : {&of_another, &unknown}) add(refused->url("https://localhost"));
  add(numbered.url("https://localhost"));
  run();
  named.wait(1);
  numbered.wait(1);
  const Json all = wait_listed([](const Json& all) {
    return all[0]["waiting"] == 0 && all[1]["waiting"] == 0 && all[2]["failures"] > 0 &&
           all[3]["failures"] > 0 && all[4]["failures"] > 0;
  });
  EXPECT_EQ(of_another.count() + unknown.count(), 0u);
  EXPECT_EQ(numbered.count(), 1u);
}

TEST_F(Webhooks, WrongRequestsAndTooMany) {
  start(false);
  for (const char* url : {"", "ftp://x", "http://user@x", "http://x:0"})
    EXPECT_EQ(add(url, 422)["errors"][0]["pointer"], "/url") << url;
  EXPECT_EQ(s_.post("/v1/webhooks", "{}", 422)["errors"][0]["pointer"], "/url");
  EXPECT_EQ(s_.post("/v1/webhooks", R"({"url":"http://x","more":1})", 422)["errors"][0]["pointer"],
            "/more");
  s_.post("/v1/webhooks", "{", 400);
  EXPECT_EQ(s_.client().Post("/v1/webhooks", "{}", "text/plain")->status, 415);
  for (size_t i = 0; i < WebhookStore::kMost; ++i) add("https://example.org/");
  add("https://example.org/", 409);
  for (const char* id : {"w99", "w", "x1", "w1x"})
    EXPECT_EQ(s_.client().Delete(std::string("/v1/webhooks/") + id)->status, 404) << id;
}

}  // namespace
}  // namespace qray::server
