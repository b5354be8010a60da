// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/http_api.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openssl/crypto.h>

#include <algorithm>
#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "host/farm/service/files/result_listing.h"
#include "host/farm/service/files/staging.h"
#include "host/farm/service/http/http_reply.h"
#include "host/farm/service/http/job_request.h"
#include "host/farm/service/http/metrics.h"
#include "host/farm/service/http/openapi.h"
#include "host/farm/service/http/result_archive.h"
#include "host/farm/service/http/web_files.h"
#include "host/farm/service/ledger/job_fields.h"
#include "host/farm/service/ledger/job_json.h"
#include "host/farm/service/workers/driver_probe.h"
#include "host/farm/service/workers/input_list.h"
#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;
using asio::use_awaitable;
using Json = nlohmann::json;

}  // namespace

struct HttpApi::State {
  using Clock = std::chrono::steady_clock;
  using Counts = std::map<std::string, std::map<JobState, std::int64_t>>;

  State(asio::io_context& context, QueueThread& queue, Dispatcher& the_dispatcher, EventHub& hub, DataFolder& the_data,
        const JobRoots& the_roots, std::string the_token, std::vector<std::string> driver_command)
      : io(context),
        ledger(queue),
        dispatcher(the_dispatcher),
        events(hub),
        data(the_data),
        token(std::move(the_token)),
        roots(the_roots),
        hashes(2),
        pictures(context, data, roots),
        driver(context, std::move(driver_command)) {}

  // Runs `work` in the ledger and rethrows its exception.
  asio::awaitable<void> in_ledger(QueueThread::Work work) {
    std::exception_ptr error;
    const auto initiate = [&](auto handler) {
      const auto shared = std::make_shared<decltype(handler)>(std::move(handler));
      ledger.run(std::move(work), [shared, &error](const std::exception_ptr& failed) {
        error = failed;
        (*shared)();
      });
    };
    co_await asio::async_initiate<const asio::use_awaitable_t<>, void()>(initiate, use_awaitable);
    if (error) std::rethrow_exception(error);
  }

  // Runs `work` on a thread that is allowed to wait for disks.
  asio::awaitable<void> beside(std::function<void()> work) {
    std::exception_ptr error;
    const auto initiate = [&](auto handler) {
      const auto shared = std::make_shared<decltype(handler)>(std::move(handler));
      asio::post(hashes.pool(), [this, shared, &error, work = std::move(work)] {
        try {
          work();
        } catch (...) {
          error = std::current_exception();
        }
        asio::post(io, [shared] { (*shared)(); });
      });
    };
    co_await asio::async_initiate<const asio::use_awaitable_t<>, void()>(initiate, use_awaitable);
    if (error) std::rethrow_exception(error);
  }

  [[noreturn]] static void refuse_unknown(const std::string& text) {
    throw Refusal{404, "not_found", fmt::format("there is no job {}", text.substr(0, 30))};
  }

  asio::awaitable<Job> job_of(std::string text) {
    const std::optional<std::int64_t> id = parse_integer(text);
    std::optional<Job> job;
    if (id) co_await in_ledger([&](JobQueue& queue) { job = queue.find(*id); });
    if (!job) refuse_unknown(text);
    co_return *job;
  }

  asio::awaitable<HttpResponse> submit(HttpRequest request) {
    if (dispatcher.is_draining()) throw Refusal{503, "ending", "the service is about to stop", {{"Retry-After", "10"}}};
    SubmitRequest asked = parse_submit(parse_body(request), roots, dispatcher.limits(), wall_clock_ms());
    JobSubmission& submission = asked.job;
    const JobType& type = find_job_type(submission.type);
    if (dispatcher.goes_to_slurm(submission.queue, submission.type)) check_is_on_nodes(asked, roots);
    if (roots.results.is_inside(submission.output)) co_await beside([&] { data.check_room(0); });
    if (!submission.output.empty() || !type.input.empty()) co_await beside([&] { look_at_files(type, asked); });
    SubmitResult result;
    Job job;
    co_await in_ledger([&](JobQueue& queue) {
      result = queue.submit(
          submission, [&](const Job& other) { return is_result_intact(roots, other); }, wall_clock_ms());
      job = *queue.find(result.id);
      queue.take_changed();
    });
    if (result.is_new) events.publish("job", job.id, job_text(job));
    dispatcher.pump();
    HttpResponse response = json_response(job_json(job), result.is_new ? 201 : 200);
    response.headers.emplace_back("Location", fmt::format("/v1/jobs/{}", job.id));
    co_return response;
  }

  // Blocks. Examines the files that a job reads, and the place of its result.
  void look_at_files(const JobType& type, SubmitRequest& asked) {
    JobSubmission& submission = asked.job;
    if (!submission.output.empty())
      StagedResult(roots.outputs, submission.output, dispatcher.instance(), 0, roots.seal)
          .check_place(type.output_is_folder);
    if (type.input.empty()) return;
    const InputList inputs = list_inputs_in_child(type, asked.parameters, roots.inputs);
    std::vector<std::string> file_hashes;
    for (const std::string& named : inputs.files) {
      const std::string file = roots.inputs.input(named);
      std::error_code not_there;
      if (!submission.output.empty() && fs::equivalent(file, submission.output, not_there))
        throw Refusal{400, "usage",
                      fmt::format("output is {}, which is also an input; expected another path", submission.output)};
      file_hashes.push_back(hashes.hash(file, roots.inputs.open_input(file)));
    }
    submission.inputs = inputs.identity;
    if (!asked.again) submission.key = idempotency_key(type, asked.parameters, file_hashes);
  }

  asio::awaitable<HttpResponse> list(HttpRequest request) {
    const JobFilter filter = parse_filter(request);
    constexpr std::int64_t kCopies = 4;  // copies of a text while an answer is made: in the row, the job, the JSON and
                                         // the JSON text
    std::int64_t bytes = 0;
    co_await in_ledger([&](JobQueue& queue) { bytes = kCopies * queue.list_bytes(filter); });
    if (!request.memory->resize(request.memory->bytes() + static_cast<std::size_t>(bytes)))
      throw Refusal{
          503, "busy", "there is not enough memory for so many jobs; request fewer jobs", {{"Retry-After", "1"}}};
    Json jobs = Json::array();
    co_await in_ledger([&](JobQueue& queue) {
      jobs = Json::array();
      for (const Job& job : queue.list(filter)) jobs.push_back(job_json(job));
    });
    for (Json& job : jobs) add_progress(job);
    co_return json_response({{"jobs", jobs}});
  }

  void add_progress(Json& json) const {
    const auto found = dispatcher.progress().find(json["id"].get<std::int64_t>());
    json["progress"] =
        found == dispatcher.progress().end()
            ? Json(nullptr)
            : Json{{"stage", found->second.stage}, {"done", found->second.done}, {"total", found->second.total}};
  }

  asio::awaitable<HttpResponse> show(std::string text) {
    // Reads all data in one transaction. With two transactions, a job could seem to run without an attempt, or to be
    // dead while an attempt is running.
    const std::optional<std::int64_t> id = parse_integer(text);
    Json json;
    if (id) co_await in_ledger([&](JobQueue& queue) { json = shown(queue, *id); });
    if (json.is_null()) refuse_unknown(text);
    add_progress(json);
    if (const SlurmPool* slurm = dispatcher.slurm())
      for (Json& part : json["parts"]) add_view(part, slurm->view({part["batch"], part["item"]}));
    co_return json_response(json);
  }

  // Returns null for an unknown job.
  static Json shown(JobQueue& queue, std::int64_t id) {
    const std::optional<Job> job = queue.find(id);
    if (!job) return nullptr;
    Json json = job_json(*job);
    json["attempts"] = Json::array();
    for (const JobAttempt& attempt : queue.attempts(id)) json["attempts"].push_back(attempt_json(attempt));
    json["parts"] = Json::array();
    for (const SlurmPart& part : queue.slurm().of_job(id)) json["parts"].push_back(part_json(part));
    return json;
  }

  static void add_view(Json& part, const std::optional<SlurmPool::PartView>& view) {
    if (!view) return;
    part["slurm_state"] = view->slurm_state;
    part["node"] = view->node;
    part["progress"] = {
        {"stage", view->progress.stage}, {"done", view->progress.done}, {"total", view->progress.total}};
  }

  // Ends only the Slurm task of one share. The share is then requested again.
  asio::awaitable<HttpResponse> cancel_part(Job job, std::string share) {
    std::vector<SlurmPart> parts;
    co_await in_ledger([&](JobQueue& queue) { parts = queue.slurm().of_job(job.id); });
    for (const SlurmPart& part : parts)
      if (part.share == share && part.state == SlurmPartState::kSent && dispatcher.slurm() != nullptr &&
          dispatcher.slurm()->cancel_part(job.id, part.batch, part.item))
        co_return json_response(job_json(job), 202);
    throw Refusal{409, "too_late", fmt::format("job {} has no part '{}' on Slurm", job.id, share)};
  }

  asio::awaitable<HttpResponse> cancel(std::string text, HttpRequest request) {
    const std::string share = parse_cancel(parse_body(request));
    const Job job = co_await job_of(std::move(text));
    if (!share.empty()) co_return co_await cancel_part(job, share);
    CancelResult result = CancelResult::kUnknown;
    std::set<std::int64_t> touched;
    co_await in_ledger([&](JobQueue& queue) {
      queue.take_changed();
      result = queue.cancel(job.id, "cancelled by request", wall_clock_ms());
      touched = queue.take_changed();
    });
    if (result == CancelResult::kTooLate)
      throw Refusal{409, "too_late", fmt::format("job {} is {}", job.id, job_state_name(job.state))};
    if (result == CancelResult::kStopWorker)
      dispatcher.stop_job(job.id, "cancelled by request", AttemptOutcome::kCancelled);
    if (!job.output.empty() && result == CancelResult::kCancelled)
      co_await beside([&] { dispatcher.remove_staging(job); });
    dispatcher.changed(touched);
    co_return json_response(job_json(co_await job_of(std::to_string(job.id))), 202);
  }

  asio::awaitable<HttpResponse> retry(std::string text) {
    const Job job = co_await job_of(std::move(text));
    RetryResult result;
    std::set<std::int64_t> touched;
    co_await in_ledger([&](JobQueue& queue) {
      queue.take_changed();
      result = queue.retry(job.id, wall_clock_ms());
      touched = queue.take_changed();
    });
    if (result.queued.empty())
      throw Refusal{409, is_final(job.state) && job.state != JobState::kSucceeded ? "need_purged" : "not_dead",
                    result.refusal};
    dispatcher.changed(touched);
    co_return json_response(job_json(co_await job_of(std::to_string(job.id))), 202);
  }

  asio::awaitable<HttpResponse> retry_dead(HttpRequest request) {
    const std::string name = parse_retry(parse_body(request));
    std::vector<std::int64_t> retried;
    std::set<std::int64_t> touched;
    co_await in_ledger([&](JobQueue& queue) {
      queue.take_changed();
      retried = queue.retry_dead(name, wall_clock_ms());
      touched = queue.take_changed();
    });
    dispatcher.changed(touched);
    co_return json_response({{"retried", retried}}, 202);
  }

  asio::awaitable<HttpResponse> purge(HttpRequest request) {
    const PurgeRequest asked = parse_purge(parse_body(request));
    std::vector<std::int64_t> purged;
    co_await in_ledger([&](JobQueue& queue) {
      purged = asked.finished_before_s
                   ? queue.purge_finished_before(wall_clock_ms() - 1000 * *asked.finished_before_s + 1, 100000)
                   : queue.purge(asked.jobs);
      queue.take_changed();
    });
    co_await beside([&] {
      dispatcher.remove_logs(purged);
      pictures.remove(purged);
    });
    co_return json_response({{"purged", purged}});
  }

  asio::awaitable<HttpResponse> log(std::string text) {
    const Job job = co_await job_of(std::move(text));
    HttpResponse response{200, "text/plain; charset=utf-8", ""};
    OpenFile file(::open(dispatcher.log_path(job.id).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (file.is_open()) response.file = std::make_shared<OpenFile>(std::move(file));
    co_return response;
  }

  asio::awaitable<HttpResponse> result(std::string text, HttpRequest request) {
    const Job job = co_await job_of(std::move(text));
    if (job.state != JobState::kSucceeded || job.output.empty())
      throw Refusal{409, "no_result",
                    fmt::format("job {} has no result to download: it is {}", job.id, job_state_name(job.state))};
    const bool is_folder = find_job_type(job.type).output_is_folder;
    const std::string name = fs::path(job.output).filename().string();
    HttpResponse response{200, is_folder ? "application/x-tar" : "application/octet-stream", ""};
    try {
      if (is_folder) response.made = co_await archive(job.output, name, *request.memory);
      else response.file = std::make_shared<OpenFile>(roots.inputs.open_input(job.output));
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kEnvironment) throw;
      throw Refusal{409, "no_result", fmt::format("the result of job {} cannot be sent: {}", job.id, error.what())};
    }
    response.headers.emplace_back("Content-Disposition", attachment(is_folder ? name + ".tar" : name));
    co_return response;
  }

  asio::awaitable<std::shared_ptr<HttpBody>> archive(std::string output, std::string name, MemoryShare& memory) {
    OpenFile folder;
    std::size_t bytes = 0;
    co_await beside([&] {
      folder = roots.inputs.open_folder_of(output + "/any");
      bytes = listing_bytes(folder);
    });
    constexpr std::size_t kCopies = 6;  // copies of the listing in memory: a text, a stream, and for each line two
                                        // texts and a map node
    if (!memory.resize(memory.bytes() + kCopies * bytes))
      throw Refusal{503, "busy", "there is not enough memory for such a long list of files", {{"Retry-After", "1"}}};
    std::shared_ptr<HttpBody> made;
    co_await beside([&] { made = std::make_shared<ResultArchive>(std::move(folder), name, roots.seal); });
    co_return made;
  }

  asio::awaitable<HttpResponse> picture(std::string text, const char* name) {
    const Job job = co_await job_of(std::move(text));
    co_return co_await pictures.answer(job, name);
  }

  asio::awaitable<HttpResponse> upload(std::string name, HttpRequest request) {
    check_upload_name(name);
    DataFolder::Upload stored;
    co_await beside([&] { stored = data.store(name, *request.upload); });
    co_await in_ledger([&](JobQueue& queue) { queue.files().note_upload(stored.path); });
    const std::string path = text_of_path(stored.path);
    const JobType& type = job_types().front();
    const Json job = {
        {"type", type.name}, {"parameters", {{type.input, path}}}, {"output", "NAME" + type.output_extension}};
    const std::string use = fmt::format("use this path as the input of a job, for example {}", job.dump());
    co_return json_response(
        {{"path", path}, {"bytes", request.upload->bytes()}, {"sha256", stored.sha256}, {"use", use}}, 201);
  }

  // Counts jobs by queue and state. The ledger's thread needs about a second to count a million jobs, and every page
  // asks once per second. So a slow count is reused for nine times its duration, and counting takes at most a tenth of
  // the thread's time.
  asio::awaitable<Counts> count_jobs() {
    constexpr double kQuick = 0.01;
    if (Clock::now() < counted_until) co_return counted;
    Counts counts;
    double seconds = 0.0;
    co_await in_ledger([&](JobQueue& queue) {
      const Stopwatch stopwatch;
      counts = queue.counts();
      seconds = stopwatch.seconds();
    });
    if (seconds > kQuick) {
      counted = counts;
      counted_until =
          Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(9.0 * seconds));
    }
    co_return counts;
  }

  asio::awaitable<HttpResponse> queues() {
    Json list = Json::array();
    Counts counts = co_await count_jobs();
    for (const auto& [name, limits] : dispatcher.limits().queues) {
      Json states = Json::object();
      for (int state = 0; state <= static_cast<int>(JobState::kCancelled); ++state)
        states[job_state_name(static_cast<JobState>(state))] = counts[name][static_cast<JobState>(state)];
      list.push_back({{"name", name},
                      {"priority", limits.priority},
                      {"jobs_max", limits.jobs_max == 1 << 30 ? Json(nullptr) : Json(limits.jobs_max)},
                      {"memory_max", limits.memory_max > 0 ? Json(limits.memory_max) : Json(nullptr)},
                      {"paused", limits.is_paused},
                      {"slurm", dispatcher.uses_slurm(name)},
                      {"jobs", states}});
    }
    co_return json_response({{"queues", list}, {"workers", dispatcher.workers().live_count()}});
  }

  HttpResponse set_paused(const std::string& name, bool is_paused) {
    if (!dispatcher.limits().queues.contains(name))
      throw Refusal{404, "not_found", fmt::format("there is no queue '{}'", name.substr(0, 60))};
    dispatcher.set_paused(name, is_paused);
    return json_response({{"name", name}, {"paused", is_paused}});
  }

  static HttpResponse types() {
    Json list = Json::array(), fields = Json::array();
    for (const JobType& type : job_types()) {
      Json views = Json::array();
      for (const JobView& view : type.views)
        for (const JobView::Shown& shown : view.shown)
          views.push_back({{"file", shown.file},
                           {"caption", shown.caption},
                           {"saved_caption", shown.saved_caption},
                           {"only_for", view.only_for}});
      list.push_back({{"name", type.name},
                      {"summary", type.summary},
                      {"input", type.input.empty() ? Json(nullptr) : Json(type.input)},
                      {"output_is_folder", type.output_is_folder},
                      {"output_extension", type.output_extension},
                      {"parameters", parameters_schema(type)},
                      {"views", views}});
    }
    constexpr std::array kForms = {"plain", "plain", "object", "time", "bytes", "job"};
    for (const JobField& field : job_fields())
      if (field.label != nullptr)
        fields.push_back(
            {{"name", field.name}, {"label", field.label}, {"form", kForms.at(static_cast<std::size_t>(field.form))}});
    return json_response({{"types", list}, {"fields", fields}});
  }

  HttpResponse event_stream(const HttpRequest& request, std::int64_t job) const {
    HttpResponse response;
    response.is_stream = true;
    response.job = job;
    const auto last = request.headers.find("last-event-id");
    const std::optional<std::int64_t> after =
        last != request.headers.end() ? parse_integer(last->second) : std::nullopt;
    response.after = after && *after >= 0 ? static_cast<std::uint64_t>(*after) : events.last();
    return response;
  }

  asio::awaitable<HttpResponse> ready() {
    co_await in_ledger([](JobQueue& queue) { queue.check_kept(); });
    const DriverProbe::Finding found = co_await driver.look();
    const int workers = dispatcher.workers().live_count();
    // If all jobs go to Slurm, only the nodes need drivers.
    const bool is_ready = !dispatcher.is_draining() && workers > 0 && (found.has_device || !dispatcher.bakes_here());
    Json json = {{"ready", is_ready}, {"workers", workers}, {"driver", found.has_device}};
    if (!found.has_device) json["message"] = text_of_message(found.message);
    co_return json_response(json, is_ready ? 200 : 503);
  }

  asio::awaitable<HttpResponse> metrics() {
    const Counts counts = co_await count_jobs();
    co_return HttpResponse{
        200, "text/plain; version=0.0.4; charset=utf-8",
        metrics_text(counts, dispatcher, server != nullptr ? server->counters() : HttpServer::Counters{},
                     ledger.pending())};
  }

  asio::io_context& io;
  QueueThread& ledger;
  Dispatcher& dispatcher;
  EventHub& events;
  DataFolder& data;
  std::string token;
  const JobRoots& roots;
  FileHashes hashes;
  JobPictures pictures;
  DriverProbe driver;
  const HttpServer* server = nullptr;
  Counts counted;
  Clock::time_point counted_until;  // until then, `counted` is the answer
};

namespace {

// The table of all requests. In a path, "{}" stands for one part.
struct Route {
  const char* method;
  std::vector<std::string> parts;
  bool is_public;  // monitors and browsers request this path without a token
  asio::awaitable<HttpResponse> (*answer)(HttpApi::State& state, std::string part, HttpRequest request);
};

template <auto kMember>
asio::awaitable<HttpResponse> with_part(HttpApi::State& state, std::string part, HttpRequest) {
  return (state.*kMember)(std::move(part));
}
template <auto kMember>
asio::awaitable<HttpResponse> with_request(HttpApi::State& state, std::string, HttpRequest request) {
  return (state.*kMember)(std::move(request));
}
template <auto kMember>
asio::awaitable<HttpResponse> alone(HttpApi::State& state, std::string, HttpRequest) {
  return (state.*kMember)();
}

asio::awaitable<HttpResponse> health(HttpApi::State&, std::string, HttpRequest) {
  co_return HttpResponse{200, "text/plain; charset=utf-8", "ok\n"};
}
asio::awaitable<HttpResponse> openapi(HttpApi::State&, std::string, HttpRequest) {
  co_return HttpResponse{200, "application/json", openapi_json};
}
asio::awaitable<HttpResponse> types(HttpApi::State& state, std::string, HttpRequest) { co_return state.types(); }
asio::awaitable<HttpResponse> pause(HttpApi::State& state, std::string part, HttpRequest) {
  co_return state.set_paused(part, true);
}
asio::awaitable<HttpResponse> resume(HttpApi::State& state, std::string part, HttpRequest) {
  co_return state.set_paused(part, false);
}
asio::awaitable<HttpResponse> all_events(HttpApi::State& state, std::string, HttpRequest request) {
  co_return state.event_stream(request, 0);
}
asio::awaitable<HttpResponse> job_events(HttpApi::State& state, std::string part, HttpRequest request) {
  const Job job = co_await state.job_of(part);
  co_return state.event_stream(request, job.id);
}
asio::awaitable<HttpResponse> result(HttpApi::State& state, std::string part, HttpRequest request) {
  return state.result(std::move(part), std::move(request));
}
asio::awaitable<HttpResponse> cancel(HttpApi::State& state, std::string part, HttpRequest request) {
  return state.cancel(std::move(part), std::move(request));
}
asio::awaitable<HttpResponse> upload(HttpApi::State& state, std::string part, HttpRequest request) {
  return state.upload(std::move(part), std::move(request));
}
asio::awaitable<HttpResponse> web_file(HttpApi::State&, std::string, HttpRequest request) {
  co_return web_file_response(request);
}
constexpr char kInputPicture[] = "input.png", kRenderPicture[] = "render.png", kErrorPicture[] = "error.png";
constexpr char kPlayerPage[] = "player.html", kLookPage[] = "look.html";
template <const char* kName>
asio::awaitable<HttpResponse> picture(HttpApi::State& state, std::string part, HttpRequest) {
  return state.picture(std::move(part), kName);
}
using State = HttpApi::State;

std::vector<Route> with_web_files(std::vector<Route> list) {
  for (const auto& [name, bytes] : web_files()) list.push_back({"GET", {name}, true, web_file});
  return list;
}

const std::vector<Route>& route_table() {
  static const std::vector<Route> list = with_web_files({
      {"GET", {"healthz"}, true, health},
      {"GET", {"readyz"}, true, alone<&State::ready>},
      {"GET", {"metrics"}, false, alone<&State::metrics>},
      {"GET", {"openapi.json"}, true, openapi},
      {"GET", {"v1", "types"}, false, types},
      {"GET", {"v1", "queues"}, false, alone<&State::queues>},
      {"POST", {"v1", "queues", "{}", "pause"}, false, pause},
      {"POST", {"v1", "queues", "{}", "resume"}, false, resume},
      {"POST", {"v1", "jobs"}, false, with_request<&State::submit>},
      {"GET", {"v1", "jobs"}, false, with_request<&State::list>},
      {"GET", {"v1", "jobs", "{}"}, false, with_part<&State::show>},
      {"POST", {"v1", "jobs", "{}", "cancel"}, false, cancel},
      {"POST", {"v1", "jobs", "{}", "retry"}, false, with_part<&State::retry>},
      {"GET", {"v1", "jobs", "{}", "log"}, false, with_part<&State::log>},
      {"GET", {"v1", "jobs", "{}", "result"}, false, result},
      {"GET", {"v1", "jobs", "{}", "events"}, false, job_events},
      {"GET", {"v1", "events"}, false, all_events},
      {"POST", {"v1", "retry"}, false, with_request<&State::retry_dead>},
      {"POST", {"v1", "purge"}, false, with_request<&State::purge>},
      {"PUT", {"v1", "uploads", "{}"}, false, upload},
      {"GET", {"v1", "jobs", "{}", "pictures", kInputPicture}, false, picture<kInputPicture>},
      {"GET", {"v1", "jobs", "{}", "pictures", kRenderPicture}, false, picture<kRenderPicture>},
      {"GET", {"v1", "jobs", "{}", "pictures", kErrorPicture}, false, picture<kErrorPicture>},
      {"GET", {"v1", "jobs", "{}", "pictures", kPlayerPage}, false, picture<kPlayerPage>},
      {"GET", {"v1", "jobs", "{}", "pictures", kLookPage}, false, picture<kLookPage>},
      {"GET", {""}, true, web_file},
  });
  return list;
}

// Stores the part for "{}" in `part`.
bool matches(const Route& route, const std::vector<std::string>& parts, std::string& part) {
  if (route.parts.size() != parts.size()) return false;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (route.parts[i] == "{}") part = parts[i];
    else if (route.parts[i] != parts[i]) return false;
  }
  return true;
}

// Returns null if the path does not support this method. In this case, `others` gets the supported methods.
const Route* find_route(const std::string& method, const std::string& path, std::string& part,
                        std::vector<std::string>& others) {
  const std::vector<std::string> parts = split_path(path);
  for (const Route& route : route_table()) {
    if (!matches(route, parts, part)) continue;
    if (route.method == method) return &route;
    others.push_back(route.method);
  }
  return nullptr;
}

bool is_same_secret(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

// Parses "Bearer TOKEN". The scheme is not case-sensitive (RFC 9110, section 11.1). Returns "" for other schemes.
std::string bearer_token(const std::string& field) {
  constexpr std::string_view kScheme = "bearer";
  const std::size_t space = field.find(' ');
  const bool is_bearer =
      space == kScheme.size() && std::equal(kScheme.begin(), kScheme.end(), field.begin(), [](char expected, char c) {
        return expected == (c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c);
      });
  const std::size_t begin = is_bearer ? field.find_first_not_of(' ', space) : std::string::npos;
  return begin == std::string::npos ? "" : field.substr(begin);
}

// A page from elsewhere must not control the service through a browser on this machine. Such a page could use a form or
// a script from another origin, or a host name whose owner points it to this machine (DNS rebinding).
bool is_own_origin(const HttpRequest& request, bool has_token, bool is_page) {
  const auto host = request.headers.find("host");
  const std::string name = host == request.headers.end() ? "" : host->second;
  const auto origin = request.headers.find("origin");
  if (origin != request.headers.end() && origin->second != "http://" + name && origin->second != "https://" + name)
    return false;
  // Requests without an origin are usually for pictures. Browsers report whether such a request comes from another
  // site. Links from other pages to this page are allowed.
  const auto site = request.headers.find("sec-fetch-site"), mode = request.headers.find("sec-fetch-mode");
  const bool is_foreign =
      site != request.headers.end() && (site->second == "cross-site" || site->second == "same-site");
  if (is_foreign && !(is_page && mode != request.headers.end() && mode->second == "navigate")) return false;
  if (has_token || name.empty()) return true;
  const std::string bare = name.starts_with('[') ? name.substr(0, name.find(']') + 1) : name.substr(0, name.find(':'));
  return bare == "127.0.0.1" || bare == "localhost" || bare == "[::1]";
}

}  // namespace

HttpApi::HttpApi(asio::io_context& io, QueueThread& ledger, Dispatcher& dispatcher, EventHub& events, DataFolder& data,
                 const JobRoots& roots, std::string token, std::vector<std::string> driver_command)
    : state_(std::make_unique<State>(io, ledger, dispatcher, events, data, roots, std::move(token),
                                     std::move(driver_command))) {}

HttpApi::~HttpApi() = default;

asio::awaitable<void> HttpApi::beside(std::function<void()> work) { return state_->beside(std::move(work)); }
void HttpApi::set_server(const HttpServer* server) { state_->server = server; }
bool HttpApi::has_token() const { return !state_->token.empty(); }
void HttpApi::set_token(std::string token) { state_->token = std::move(token); }
JobPictures& HttpApi::pictures() { return state_->pictures; }

bool HttpApi::is_upload(const std::string& method, const std::string& path) {
  return method == "PUT" && path.starts_with("/v1/uploads/");
}

std::vector<std::string> HttpApi::routes() {
  std::vector<std::string> names;
  for (const Route& route : route_table())
    if (route.answer != web_file)  // the page is not for programs
      names.push_back(fmt::format("{} /{}", route.method, fmt::join(route.parts, "/")));
  return names;
}

std::unique_ptr<HttpResponse> HttpApi::check(const HttpRequest& request) const {
  const auto refuse = [](const Refusal& refusal) { return std::make_unique<HttpResponse>(refusal_response(refusal)); };
  std::string part;
  std::vector<std::string> others;
  const Route* route = find_route(request.method, request.path, part, others);
  if (route == nullptr && !others.empty())
    return refuse({405,
                   "method",
                   fmt::format("expected {}", fmt::join(others, " or ")),
                   {{"Allow", fmt::format("{}", fmt::join(others, ", "))}}});
  if (route == nullptr) return refuse({404, "not_found", "there is no such path"});
  if (!is_own_origin(request, has_token(), route->answer == web_file))
    return refuse({403, "origin", "the request comes from a page of another origin"});
  if (has_token() && !route->is_public) {
    const auto given = request.headers.find("authorization");
    const auto query = request.query.find("access_token");  // for event streams, whose headers browsers cannot set
    const bool is_known =
        (given != request.headers.end() && is_same_secret(bearer_token(given->second), state_->token)) ||
        (query != request.query.end() && request.method == "GET" && is_same_secret(query->second, state_->token));
    if (!is_known)
      return refuse({401, "token", "a bearer token is required", {{"WWW-Authenticate", "Bearer realm=\"multum\""}}});
  }
  return nullptr;
}

asio::awaitable<HttpResponse> HttpApi::answer(HttpRequest request) {
  request.query.erase("access_token");
  try {
    std::string part;
    std::vector<std::string> others;
    const Route* route = find_route(request.method, request.path, part, others);
    MULTUM_CHECK(route != nullptr);  // check() has accepted it
    co_return co_await route->answer(*state_, part, std::move(request));
  } catch (const Refusal& refusal) {
    co_return refusal_response(refusal);
  } catch (const Error& error) {
    co_return refusal_response(refusal_of(error));
  } catch (const std::exception& error) {
    co_return refusal_response({500, "internal", error.what()});
  }
}

}  // namespace multum
