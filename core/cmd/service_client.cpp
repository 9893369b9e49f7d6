#include "core/cmd/service_client.h"

#include <httplib.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <regex>

#include "core/cmd/report.h"

namespace qray::cmd {
namespace {

constexpr int kConnectSeconds = 5;
constexpr int kReadSeconds = 30;    // of silence; the server's heartbeats come every 10 s
constexpr int kSceneSeconds = 600;  // the server reads the scene before it answers
constexpr size_t kMaxImageBytes = size_t{1} << 30;

ErrorCode code_of_status(int status) {
  switch (status) {
    case 404:
      return ErrorCode::kNotFound;
    case 409:
      return ErrorCode::kConflict;
    case 413:
      return ErrorCode::kTooLarge;
    case 429:
    case 503:
      return ErrorCode::kBusy;
    default:
      return ErrorCode::kInvalid;
  }
}

Error refusal(int status, const std::string& body, const std::string& where) {
  return {code_of_status(status),
          "the server answered " + std::to_string(status) + ": " +
              proto::problem_text(body).value_or("not as a qray server does"),
          where};
}

// Job ids come from the command line and go into a path.
Status check_id(const std::string& id) {
  const bool good = !id.empty() && id.size() <= 64 && std::all_of(id.begin(), id.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' ||
           c == '_';
  });
  if (good) return {};
  return Error{ErrorCode::kInvalid, "expected a job's id such as j000001, got '" + id + "'", ""};
}

}  // namespace

struct ServiceClient::Impl {
  std::string url;
  httplib::Client http;

  explicit Impl(const std::string& u) : url(u), http(u) {
    http.set_connection_timeout(kConnectSeconds);
    http.set_read_timeout(kReadSeconds);
    http.set_tcp_nodelay(true);
  }

  Error unreachable(httplib::Error error) const {
    return {ErrorCode::kIo, "no answer: " + httplib::to_string(error) + " error", url};
  }

  // The answer to a call that gives a job.
  Result<proto::JobView> job_of(const httplib::Result& result) const {
    if (!result) return unreachable(result.error());
    if (result->status / 100 != 2) return refusal(result->status, result->body, url);
    return proto::parse_job(result->body);
  }
};

ServiceClient::ServiceClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ServiceClient::~ServiceClient() = default;

Result<std::unique_ptr<ServiceClient>> ServiceClient::open(const ServerAddress& server) {
  const std::string& url = server.url;
  const Error bad{ErrorCode::kInvalid,
                  "expected a server such as http://127.0.0.1:8080, got '" + url + "'", "--server"};
  static const std::regex form(R"((https?://([A-Za-z0-9.-]+|\[[0-9A-Fa-f:.]+\])(:[0-9]{1,5})?)/?)");
  std::smatch match;
  if (!std::regex_match(url, match, form)) return bad;
  std::signal(SIGPIPE, SIG_IGN);  // a server that hangs up while we send is an error, not our end
  auto impl = std::make_unique<Impl>(match[1].str());
  if (!impl->http.is_valid()) return bad;
  if (server.token.find_first_of("\r\n") != std::string::npos)
    return Error{ErrorCode::kInvalid, "expected one line", "--token"};
  if (!server.token.empty()) impl->http.set_bearer_token_auth(server.token.c_str());
  return std::unique_ptr<ServiceClient>(new ServiceClient(std::move(impl)));
}

Status ServiceClient::put_asset(const std::string& sha256, const std::filesystem::path& file,
                                uint64_t bytes) {
  const std::string address = "/v1/assets/" + sha256;
  const httplib::Result there = impl_->http.Head(address);
  if (!there) return impl_->unreachable(there.error());
  if (there->status == 200) return {};
  std::ifstream in(file, std::ios::binary);
  std::vector<char> block(size_t{1} << 20);
  const auto provide = [&](size_t, size_t length, httplib::DataSink& sink) {
    in.read(block.data(), static_cast<std::streamsize>(std::min(length, block.size())));
    const auto got = static_cast<size_t>(in.gcount());
    return got > 0 && sink.write(block.data(), got);
  };
  const char* type = "application/octet-stream";
  const httplib::Result result = bytes > 0 ? impl_->http.Put(address, bytes, provide, type)
                                           : impl_->http.Put(address, std::string(), type);
  // Its answer, if it gave one, is lost.
  if (result.error() == httplib::Error::Write || result.error() == httplib::Error::Canceled)
    return Error{ErrorCode::kTooLarge,
                 "the server hung up while this was sent: it may be larger than it takes (64 MiB "
                 "unless told otherwise), or shorter than it was",
                 file.string()};
  if (!result) return impl_->unreachable(result.error());
  if (result->status / 100 == 2) return {};
  return refusal(result->status, result->body, file.string());
}

Result<proto::SceneView> ServiceClient::post_scene(const proto::SceneSubmission& submission) {
  impl_->http.set_read_timeout(kSceneSeconds);
  const httplib::Result result =
      impl_->http.Post("/v1/scenes", proto::scene_submission_json(submission), "application/json");
  impl_->http.set_read_timeout(kReadSeconds);
  if (!result) return impl_->unreachable(result.error());
  if (result->status / 100 != 2) return refusal(result->status, result->body, impl_->url);
  return proto::parse_scene(result->body);
}

Result<proto::JobView> ServiceClient::submit(const JobRequest& request) {
  return impl_->job_of(
      impl_->http.Post("/v1/jobs", proto::job_request_to_json(request), "application/json"));
}

Result<proto::JobView> ServiceClient::job(const std::string& id) {
  if (Status s = check_id(id); !s) return s.error();
  return impl_->job_of(impl_->http.Get("/v1/jobs/" + id));
}

Result<proto::JobView> ServiceClient::act(const std::string& id, const std::string& action) {
  if (Status s = check_id(id); !s) return s.error();
  return impl_->job_of(impl_->http.Post("/v1/jobs/" + id + "/" + action, "", "application/json"));
}

Result<proto::JobView> ServiceClient::extend(const std::string& id,
                                             const proto::ExtendRequest& more) {
  if (Status s = check_id(id); !s) return s.error();
  return impl_->job_of(impl_->http.Post("/v1/jobs/" + id + "/extend",
                                        proto::extend_request_to_json(more), "application/json"));
}

Result<std::string> ServiceClient::log(const std::string& id) {
  if (Status s = check_id(id); !s) return s.error();
  const httplib::Result result = impl_->http.Get("/v1/jobs/" + id + "/log");
  if (!result) return impl_->unreachable(result.error());
  if (result->status != 200) return refusal(result->status, result->body, impl_->url);
  return result->body;
}

Result<Bytes> ServiceClient::image(const std::string& id, const std::string& format,
                                   const std::string& exposure) {
  if (Status s = check_id(id); !s) return s.error();
  std::string path = "/v1/jobs/" + id + "/image." + format;
  if (format == "png") path += "?exposure=" + exposure;
  Bytes bytes;
  const httplib::Result result = impl_->http.Get(path, [&](const char* data, size_t size) {
    if (bytes.size() + size > kMaxImageBytes) return false;
    bytes.insert(bytes.end(), data, data + size);
    return true;
  });
  if (!result && result.error() == httplib::Error::Canceled)
    return Error{ErrorCode::kTooLarge, "a picture of over 1 GiB", impl_->url};
  if (!result) return impl_->unreachable(result.error());
  if (result->status != 200)
    return refusal(result->status, std::string(bytes.begin(), bytes.end()), impl_->url);
  return bytes;
}

Status ServiceClient::events(const std::string& id, const std::string& after,
                             const std::function<bool(const ServerEvent&)>& on_event) {
  if (Status s = check_id(id); !s) return s;
  httplib::Headers headers{{"Accept", "text/event-stream"}};
  if (!after.empty()) headers.emplace("Last-Event-ID", after);
  EventReader reader;
  int status = 0;
  std::string refused;
  const httplib::Result result = impl_->http.Get(
      "/v1/events?job=" + id, headers,
      [&](const httplib::Response& response) {
        status = response.status;
        return true;
      },
      [&](const char* data, size_t size) {
        if (status != 200) {
          refused.append(data, std::min<size_t>(size, 65536));
          return refused.size() < 65536;
        }
        for (const ServerEvent& event : reader.feed({data, size}))
          if (!on_event(event)) return false;
        return true;
      });
  if (status != 0 && status != 200) return refusal(status, refused, impl_->url);
  if (!result && result.error() != httplib::Error::Canceled)
    return impl_->unreachable(result.error());
  return {};
}

void add_server_option(CLI::App& app, ServerAddress& server) {
  server.url = "http://127.0.0.1:8080";
  app.add_option("--server", server.url, "the server's URL")
      ->envname("QRAY_SERVER")
      ->capture_default_str();
  app.add_option("--token", server.token, "for a server that asks for one; better as the variable")
      ->envname("QRAY_TOKEN");
}

int report_client(const Error& error) {
  const int code = report(error);
  return error.code == ErrorCode::kIo ? kExitUnreachable : code;
}

int report_end(const proto::JobView& job) {
  std::printf("%s %s\n", job.id.c_str(), job.state.c_str());
  if (job.state == "succeeded") return kExitOk;
  if (job.state == "canceled") return kExitCanceled;
  std::fprintf(stderr, "qray: %s: %s\n", job.id.c_str(), job.error.c_str());
  return kExitJobFailed;
}

}  // namespace qray::cmd
