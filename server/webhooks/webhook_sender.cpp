#include "server/webhooks/webhook_sender.h"

#include <openssl/hmac.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <condition_variable>

#include "server/webhooks/post.h"
#include "server/webhooks/url.h"

namespace qray::server {
namespace {

constexpr std::chrono::seconds kBetweenLooks{1};
constexpr uint64_t kMostDoublings = 11;

std::string request_for(const WebhookUrl& url, const Delivery& delivery, int64_t now_ms,
                        const std::string& body) {
  const int64_t seconds = now_ms / 1000;
  return "POST " + url.target + " HTTP/1.1\r\nHost: " + url.host_field +
         "\r\nUser-Agent: qray\r\nContent-Type: application/json\r\nContent-Length: " +
         std::to_string(body.size()) + "\r\nQray-Delivery: " + std::to_string(delivery.id) +
         "\r\nQray-Signature: t=" + std::to_string(seconds) +
         ",v1=" + webhook_signature(delivery.webhook.secret, seconds, body) +
         "\r\nConnection: close\r\n\r\n" + body;
}

}  // namespace

std::string webhook_signature(const std::string& secret, int64_t seconds, std::string_view body) {
  const std::string text = std::to_string(seconds) + "." + std::string(body);
  Digest digest;
  unsigned size = 0;
  ::HMAC(::EVP_sha256(), secret.data(), static_cast<int>(secret.size()),
         reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.bytes.data(),
         &size);
  return digest.hex();
}

WebhookSender::WebhookSender(WebhookStore& webhooks, const JobStore& jobs, const Limits& limits,
                             std::function<int64_t()> now_ms)
    : webhooks_(webhooks), jobs_(jobs), limits_(limits), now_ms_(std::move(now_ms)) {
  thread_ = std::jthread([this](std::stop_token stop) {
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
      try {
        send_due(stop);
      } catch (const std::exception& e) {
        spdlog::error("webhooks: {}", e.what());
      }
      never.wait_for(lock, stop, kBetweenLooks, [] { return false; });
    }
  });
}

void WebhookSender::stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void WebhookSender::send_due(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const Result<std::optional<Delivery>> due = webhooks_.next();
    if (!due.ok()) return spdlog::error("webhooks: {}", due.error().text());
    if (!due.value()) return;
    const Status sent = send(*due.value(), stop);
    if (stop.stop_requested() && !sent.ok()) return;  // at the next start
    settle(*due.value(), sent);
  }
}

Status WebhookSender::send(const Delivery& delivery, const std::stop_token& stop) {
  const Result<JobRecord> job = jobs_.get(delivery.job);
  if (!job.ok()) return job.error().code == ErrorCode::kNotFound ? Status() : job.error();
  const auto deadline = std::chrono::steady_clock::now() + limits_.try_takes;
  const Result<WebhookUrl> url = parse_webhook_url(delivery.webhook.url);
  if (!url.ok()) return url.error();
  const auto addresses = resolve(url.value().host, url.value().port, deadline, stop);
  if (!addresses.ok()) return addresses.error();
  for (const Address& address : addresses.value())
    if (!limits_.private_addresses && !is_public(address))
      return Error{ErrorCode::kInvalid, "its name leads to an address that is not public",
                   url.value().host};
  const std::string body = proto::webhook_event(job.value().info());
  const std::string request = request_for(url.value(), delivery, now_ms_(), body);
  const Result<int> status = post(url.value(), addresses.value()[0], request, deadline, stop);
  if (!status.ok()) return status.error();
  if (status.value() / 100 == 2) return {};
  return Error{ErrorCode::kIo,
               "expected an answer of 200..299, got " + std::to_string(status.value()),
               url.value().host};
}

void WebhookSender::settle(const Delivery& delivery, const Status& sent) {
  Status settled;
  const char* then = "";
  if (sent.ok()) {
    settled = webhooks_.delivered(delivery);
  } else if (now_ms_() - delivery.created_ms > limits_.gives_up.count()) {
    then = "; it is not told of this end any more";
    settled = webhooks_.give_up(delivery);
  } else {
    const int64_t delay = limits_.first_delay.count()
                          << std::min(delivery.webhook.failures, kMostDoublings);
    settled = webhooks_.failed(delivery, std::min(delay, WebhookStore::kLongestDelayMs));
  }
  if (!sent.ok())
    spdlog::warn("job={} webhook {}: {}{}", delivery.job.text(), delivery.webhook.id,
                 sent.error().text(), then);
  if (!settled.ok()) {  // a disk that is full; else it would be sent again at once
    spdlog::error("webhook {}: {}", delivery.webhook.id, settled.error().text());
    std::this_thread::sleep_for(kBetweenLooks);
  }
}

}  // namespace qray::server
