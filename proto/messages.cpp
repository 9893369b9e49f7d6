#include "proto/messages.h"

#include <ctime>
#include <nlohmann/json.hpp>

#include "proto/camera_json.h"

namespace qray::proto {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Bytes that are not UTF-8 (file names, texts cut short) become U+FFFD rather than an exception.
std::string text_of(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

template <class T>
OrderedJson or_null(const std::optional<T>& value) {
  return value ? OrderedJson(*value) : OrderedJson(nullptr);
}

OrderedJson or_null(const std::string& text) {
  return text.empty() ? OrderedJson(nullptr) : OrderedJson(text);
}

OrderedJson time_or_null(const std::optional<int64_t>& ms) {
  return ms ? OrderedJson(time_to_text(*ms)) : OrderedJson(nullptr);
}

OrderedJson value_json(const FieldValue& value) {
  return std::visit([](const auto& v) { return OrderedJson(v); }, value);
}

OrderedJson request_json(const JobRequest& request, const FieldTable& fields) {
  OrderedJson out = OrderedJson::object();
  for (const Field& field : fields) {
    const FieldValue* value = request.find(field.path);
    if (!value) continue;
    OrderedJson& object = field.group().empty() ? out : out[std::string(field.group())];
    const bool word = !field.zero.empty() && std::get<int64_t>(*value) == 0;
    object[std::string(field.name())] = word ? OrderedJson(field.zero) : value_json(*value);
  }
  return out;
}

OrderedJson job_json(const JobInfo& job) {
  OrderedJson out = {{"id", job.id},
                     {"state", job.state},
                     {"request", request_json(job.request, job_fields())},
                     {"created", time_to_text(job.created_ms)},
                     {"started", time_or_null(job.started_ms)},
                     {"ended", time_or_null(job.ended_ms)},
                     {"progress",
                      {{"fraction", job.progress.fraction},
                       {"samples", job.progress.samples},
                       {"seconds", job.progress.seconds}}},
                     {"error", nullptr},
                     {"table_in", or_null(job.table_in)},
                     {"table_out", or_null(job.table_out)},
                     {"stats", nullptr},
                     {"biased", job.biased},
                     {"warnings", job.warnings},
                     {"extendable", job.extendable}};
  if (job.error) out["error"] = {{"message", job.error->message}, {"where", job.error->where}};
  if (!job.stats_json.empty()) {
    OrderedJson stats = OrderedJson::parse(job.stats_json, nullptr, false);
    if (!stats.is_discarded()) out["stats"] = std::move(stats);
  }
  return out;
}

OrderedJson webhook_json(const WebhookInfo& w) {
  return {{"id", w.id},
          {"url", w.url},
          {"created", time_to_text(w.created_ms)},
          {"failures", w.failures},
          {"waiting", w.waiting}};
}

OrderedJson table_json(const TableInfo& t) {
  return {{"id", t.id},
          {"scene", t.scene},
          {"method", t.method},
          {"parents", t.parents},
          {"created", time_to_text(t.created_ms)},
          {"bytes", t.bytes},
          {"states", t.states},
          {"samples_seen", t.samples_seen},
          {"job", or_null(t.job)}};
}

OrderedJson weights_json(const WeightsInfo& w) {
  return {{"id", w.id},           {"scene", w.scene},
          {"program", w.program}, {"created", time_to_text(w.created_ms)},
          {"bytes", w.bytes},     {"steps", w.steps},
          {"views", w.views},     {"held_out", or_null(w.held_out)}};
}

OrderedJson scene_json(const SceneInfo& s) {
  return {{"name", s.name},
          {"width", or_null(s.width)},
          {"height", or_null(s.height)},
          {"uploaded", s.uploaded},
          {"title", s.title.empty() ? s.name : s.title}};
}

}  // namespace

std::string time_to_text(int64_t ms) {
  const std::time_t seconds = static_cast<std::time_t>(ms / 1000);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char day[32], text[48];
  std::strftime(day, sizeof day, "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text, sizeof text, "%s.%03dZ", day, static_cast<int>(ms % 1000));
  return text;
}

std::optional<int64_t> parse_time(std::string_view text) {
  constexpr std::string_view kForm = "0000-00-00T00:00:00";
  if (text.size() <= kForm.size() || text.back() != 'Z') return {};
  for (size_t i = 0; i < kForm.size(); ++i) {
    const bool digit = text[i] >= '0' && text[i] <= '9';
    if (kForm[i] == '0' ? !digit : text[i] != kForm[i]) return {};
  }
  const auto number = [&](size_t at, size_t digits) {
    int value = 0;
    for (size_t i = at; i < at + digits; ++i) value = value * 10 + (text[i] - '0');
    return value;
  };
  std::tm parts{};
  parts.tm_year = number(0, 4) - 1900;
  parts.tm_mon = number(5, 2) - 1;
  parts.tm_mday = number(8, 2);
  parts.tm_hour = number(11, 2);
  parts.tm_min = number(14, 2);
  parts.tm_sec = number(17, 2);
  const std::tm given = parts;
  const int64_t seconds = ::timegm(&parts);  // makes another day of the 31st of April
  if (parts.tm_mon != given.tm_mon || parts.tm_mday != given.tm_mday || given.tm_hour > 23 ||
      given.tm_min > 59 || given.tm_sec > 59)
    return {};
  std::string_view fraction = text.substr(kForm.size(), text.size() - kForm.size() - 1);
  if (fraction.empty()) return seconds * 1000;
  if (fraction.size() < 2 || fraction.size() > 10 || fraction[0] != '.') return {};
  fraction.remove_prefix(1);
  if (fraction.find_first_not_of("0123456789") != std::string_view::npos) return {};
  int64_t ms = 0;
  for (size_t i = 0; i < 3; ++i) ms = ms * 10 + (i < fraction.size() ? fraction[i] - '0' : 0);
  return seconds * 1000 + ms;
}

std::string job_request_to_json(const JobRequest& request, const FieldTable& fields) {
  return text_of(request_json(request, fields));
}

std::string extend_request_to_json(const ExtendRequest& request) {
  OrderedJson out = OrderedJson::object();
  if (request.samples) out["samples"] = *request.samples;
  if (request.seconds) out["seconds"] = *request.seconds;
  if (request.noise) out["noise"] = *request.noise;
  return text_of(out);
}

std::string comparison_to_json(const Comparison& c) {
  const auto difference = [](const PictureDifference& d) {
    return OrderedJson{{"relmse", d.relmse},
                       {"relmse_trimmed", d.relmse_trimmed},
                       {"flip", d.flip},
                       {"mean_ratio", d.mean_ratio},
                       {"max_abs", d.max_abs}};
  };
  OrderedJson out = {
      {"a", c.a}, {"b", c.b}, {"ref", or_null(c.ref)}, {"difference", difference(c.difference)}};
  if (c.a_error) out["a_error"] = difference(*c.a_error);
  if (c.b_error) out["b_error"] = difference(*c.b_error);
  return text_of(out);
}

std::string frames_to_json(std::string_view job, std::span<const FrameInfo> frames) {
  OrderedJson list = OrderedJson::array();
  for (const FrameInfo& f : frames) {
    OrderedJson stats = OrderedJson::parse(f.stats_json, nullptr, false);
    list.push_back({{"frame", f.frame},
                    {"camera", or_null(f.camera)},
                    {"state", f.state},
                    {"fraction", f.fraction},
                    {"samples", f.samples},
                    {"seconds", f.seconds},
                    {"noise", f.noise > 0 ? OrderedJson(f.noise) : OrderedJson()},
                    {"stats", stats.is_discarded() ? OrderedJson() : std::move(stats)}});
  }
  return text_of({{"job", job}, {"frames", std::move(list)}});
}

std::string passes_to_json(std::string_view job, std::span<const std::string> layers) {
  return text_of(
      {{"job", job}, {"layers", std::vector<std::string>(layers.begin(), layers.end())}});
}

std::string light_groups_to_json(std::string_view job, std::span<const std::string> groups) {
  return text_of(
      {{"job", job}, {"groups", std::vector<std::string>(groups.begin(), groups.end())}});
}

std::vector<std::string> light_groups_of_stats(std::string_view stats_json) {
  const OrderedJson stats = OrderedJson::parse(stats_json, nullptr, false);
  std::vector<std::string> names;
  if (!stats.is_object() || !stats.contains("light_groups")) return names;
  for (const OrderedJson& name : stats["light_groups"])
    if (name.is_string()) names.push_back(name.get<std::string>());
  return names;
}

std::vector<FrameInfo> parse_frame_infos(std::string_view json) {
  const OrderedJson tree = OrderedJson::parse(json, nullptr, false);
  std::vector<FrameInfo> frames;
  try {
    for (const OrderedJson& f : tree.at("frames")) {
      FrameInfo info;
      info.frame = f.at("frame");
      if (f.at("camera").is_string()) info.camera = f.at("camera");
      info.state = f.at("state");
      info.fraction = f.at("fraction");
      info.samples = f.at("samples");
      info.seconds = f.at("seconds");
      if (f.at("noise").is_number()) info.noise = f.at("noise");
      if (f.at("stats").is_object()) info.stats_json = f.at("stats").dump();
      frames.push_back(std::move(info));
    }
  } catch (const OrderedJson::exception&) {
    frames.clear();
  }
  return frames;
}

std::string metrics_to_json(const JobMetrics& metrics) {
  const auto known = [](double v) { return v > 0 ? OrderedJson(v) : OrderedJson(nullptr); };
  OrderedJson moments = OrderedJson::array();
  for (const Moment& m : metrics.moments) {
    OrderedJson moment = {{"number", m.number},
                          {"samples", m.samples},
                          {"seconds", m.seconds},
                          {"noise", known(m.noise)},
                          {"learning", m.learning},
                          {"guided", m.guided},
                          {"efficiency_gain", known(m.efficiency_gain)},
                          {"states", m.states},
                          {"direction_nodes", m.direction_nodes},
                          {"table_bytes", m.table_bytes},
                          {"picture", m.picture},
                          {"table", m.table}};
    if (const auto found = metrics.relmse.find(m.number); found != metrics.relmse.end())
      moment["relmse"] = found->second;
    moments.push_back(std::move(moment));
  }
  const std::string gate = metrics.moments.empty() ? "" : metrics.moments.back().gate;
  return text_of({{"job", metrics.job},
                  {"ref", or_null(metrics.ref)},
                  {"gate", or_null(gate)},
                  {"moments", std::move(moments)}});
}

std::string pixel_to_json(const PixelInfo& pixel) {
  OrderedJson out = {{"x", pixel.x},
                     {"y", pixel.y},
                     {"radiance", pixel.radiance},
                     {"samples", pixel.samples},
                     {"variance", or_null(pixel.variance)},
                     {"standard_error", or_null(pixel.standard_error)},
                     {"surface", nullptr},
                     {"state", nullptr},
                     {"lobe", nullptr}};
  if (pixel.surface)
    out["surface"] = {{"position", pixel.surface->first}, {"normal", pixel.surface->second}};
  if (!pixel.state) return text_of(out);
  const PixelState& state = *pixel.state;
  char id[17];
  std::snprintf(id, sizeof id, "%016llx", static_cast<unsigned long long>(state.id));
  out["state"] = {{"id", id},
                  {"color", state.color},
                  {"known", state.known},
                  {"size", or_null(state.size_m)},
                  {"visits", or_null(state.visits)},
                  {"gain", state.gain},
                  {"guide_fraction", state.guide_fraction}};
  if (state.directions.empty()) return text_of(out);
  OrderedJson directions = OrderedJson::array(), cells = OrderedJson::array();
  for (const PixelDirection& d : state.directions)
    directions.push_back({{"wi", d.wi}, {"pdf_w", d.pdf_w}, {"screen", or_null(d.screen)}});
  for (const DirectionSquare& c : state.cells)
    cells.push_back({{"u", c.u}, {"v", c.v}, {"size", c.size}, {"pdf_w", c.pdf_w}});
  out["lobe"] = {{"directions", std::move(directions)},
                 {"cells", state.cells.empty() ? OrderedJson(nullptr) : std::move(cells)}};
  return text_of(out);
}

std::string job_to_json(const JobInfo& job) { return text_of(job_json(job)); }

std::string job_list_to_json(std::span<const JobInfo> jobs, std::string_view next) {
  OrderedJson out = {{"jobs", OrderedJson::array()}};
  for (const JobInfo& job : jobs) out["jobs"].push_back(job_json(job));
  if (!next.empty()) out["next"] = next;
  return text_of(out);
}

std::string deleted_to_json(std::span<const std::string> jobs, bool more) {
  OrderedJson out = {{"deleted", OrderedJson::array()}, {"more", more}};
  for (const std::string& id : jobs) out["deleted"].push_back(id);
  return text_of(out);
}

std::string webhook_to_json(const WebhookInfo& webhook, std::string_view secret) {
  OrderedJson out = webhook_json(webhook);
  if (!secret.empty()) out["secret"] = secret;
  return text_of(out);
}

std::string webhook_list_to_json(std::span<const WebhookInfo> webhooks) {
  OrderedJson out = {{"webhooks", OrderedJson::array()}};
  for (const WebhookInfo& webhook : webhooks) out["webhooks"].push_back(webhook_json(webhook));
  return text_of(out);
}

std::string webhook_event(const JobInfo& job) {
  return text_of(OrderedJson{{"event", "job.ended"}, {"job", job_json(job)}});
}

std::string table_to_json(const TableInfo& table) { return text_of(table_json(table)); }

std::string table_list_to_json(std::span<const TableInfo> tables, std::string_view next) {
  OrderedJson out = {{"tables", OrderedJson::array()}};
  for (const TableInfo& t : tables) out["tables"].push_back(table_json(t));
  if (!next.empty()) out["next"] = next;
  return text_of(out);
}

std::string weights_to_json(const WeightsInfo& weights) { return text_of(weights_json(weights)); }

std::string weights_list_to_json(std::span<const WeightsInfo> weights) {
  OrderedJson list = OrderedJson::array();
  for (const WeightsInfo& w : weights) list.push_back(weights_json(w));
  return text_of({{"weights", std::move(list)}});
}

std::string scene_list_to_json(std::span<const SceneInfo> scenes) {
  OrderedJson list = OrderedJson::array();
  for (const SceneInfo& s : scenes) list.push_back(scene_json(s));
  return text_of({{"scenes", std::move(list)}});
}

std::string scene_to_json(const SceneInfo& scene, const SceneReport* report) {
  OrderedJson out = scene_json(scene);
  out["cameras"] = scene.cameras;
  if (report) {
    out["entry"] = report->entry;
    out["triangles"] = report->triangles;
    out["warnings"] = report->warnings;
  }
  return text_of(out);
}

std::string scene_report_to_json(const SceneReport& report) {
  OrderedJson out = {{"entry", report.entry},
                     {"width", report.width},
                     {"height", report.height},
                     {"triangles", report.triangles},
                     {"unpacked_bytes", report.unpacked_bytes},
                     {"warnings", report.warnings}};
  if (!report.title.empty()) out["title"] = report.title;
  if (!report.cameras.empty()) out["cameras"] = report.cameras;
  if (report.error)
    out["error"] = {{"message", report.error->message}, {"where", report.error->where}};
  return text_of(out);
}

std::optional<SceneReport> parse_scene_report(std::string_view json) {
  const OrderedJson tree = OrderedJson::parse(json, nullptr, false);
  if (!tree.is_object()) return std::nullopt;
  try {
    SceneReport report{{},
                       tree.at("entry"),
                       tree.at("width"),
                       tree.at("height"),
                       tree.at("triangles"),
                       tree.at("unpacked_bytes"),
                       tree.at("warnings")};
    if (const auto error = tree.find("error"); error != tree.end())
      report.error = JobError{error->at("message"), error->at("where")};
    if (const auto title = tree.find("title"); title != tree.end()) report.title = *title;
    if (const auto cameras = tree.find("cameras"); cameras != tree.end())
      report.cameras = cameras->get<std::vector<std::string>>();
    return report;
  } catch (const OrderedJson::exception&) {
    return std::nullopt;
  }
}

std::string scene_manifest(const SceneRequest& request) {
  return text_of({{"entry", request.entry}, {"files", request.files}, {"zip", request.archive}});
}

std::string file_pointer(std::string_view name) {
  std::string pointer = "/files/";
  for (char c : name) pointer += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return pointer;
}

std::string asset_to_json(std::string_view sha256) { return text_of({{"sha256", sha256}}); }

std::string health_to_json() { return R"({"status":"ok"})"; }

std::string problem_to_json(const Problem& problem) {
  OrderedJson out = {{"type", "about:blank"}, {"title", problem.title}, {"status", problem.status}};
  if (!problem.detail.empty()) out["detail"] = problem.detail;
  if (!problem.errors.empty()) {
    out["errors"] = OrderedJson::array();
    for (const FieldError& e : problem.errors) {
      out["errors"].push_back({{"pointer", e.pointer}, {"detail", e.detail}});
    }
  }
  return text_of(out);
}

}  // namespace qray::proto
