// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/job_pictures.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "host/farm/service/files/staging.h"
#include "host/farm/service/http/http_reply.h"
#include "host/farm/service/log/service_log.h"
#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/process_rules/process_rules.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;
using asio::use_awaitable;

constexpr auto kTimeMax = std::chrono::seconds(60);
constexpr int kNiceness = 10;  // children have a lower priority than jobs
constexpr std::uint64_t kMemoryMax = std::uint64_t{3} << 30;
constexpr char kSaid[] = "said.txt", kSources[] = "sources.txt";
// The page contains all its data. The page may run its own script and save recorded paths as files, but it has no
// origin. Malicious data in the page can therefore reach neither the service nor a token.
constexpr char kPagePolicy[] =
    "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; "
    "worker-src blob:; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'";
constexpr std::size_t kReasonMax = 400;  // bytes of a reason
constexpr std::size_t kWaitingMax = 64;  // number of waiting jobs, which usually take about a minute

[[noreturn]] void refuse(const std::string& why) { throw Refusal{404, "no_picture", why}; }

// Looks next to this program, then in PATH.
std::string find_program(const std::string& name) {
  std::vector<fs::path> folders = {program_folder()};
  const char* path = std::getenv("PATH");
  for (std::string_view rest = path != nullptr ? path : ""; !rest.empty();) {
    const std::string_view one = rest.substr(0, rest.find(':'));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    if (!one.empty()) folders.emplace_back(one);
  }
  for (const fs::path& folder : folders)
    if (::access((folder / name).c_str(), X_OK) == 0) return (folder / name).string();
  refuse(name + " is not installed: it is neither in the folder of multum nor in PATH");
}

std::string last_line(const std::string& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) last = line;
  return last.substr(0, kReasonMax);
}

// Returns the number at the beginning of a folder's name, or 0 if there is none.
std::int64_t id_of(const std::string& name) {
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
  return error == std::errc() && end != name.data() + name.size() && *end == '-' ? id : 0;
}

bool is_page(const std::string& name) { return name.ends_with(".html"); }

// Returns whether an earlier daemon made a view of any type in this folder.
bool has_view(const fs::path& folder) {
  for (const JobType& type : job_types())
    for (const JobView& view : type.views)
      if (std::error_code ignored; fs::exists(folder / view.files.front(), ignored)) return true;
  return false;
}

std::string end_of(const ChildResult& result, const std::string& program) {
  if (result.is_over_time) return fmt::format("{} took more than {} s and was killed", program, kTimeMax.count());
  if (result.signal != 0) return fmt::format("{} was terminated by signal {}", program, result.signal);
  return "";  // the reader has printed the error
}

const JobView& find_view(const Job& job, const std::string& name) {
  const JobType& type = find_job_type(job.type);
  if (type.views.empty()) refuse("there are no pictures of a " + job.type + " job");
  if (job.state != JobState::kSucceeded)
    refuse(
        fmt::format("job {} is {}; pictures exist only after a job has succeeded", job.id, job_state_name(job.state)));
  const JobView* const view = type.find_view(name);
  if (view == nullptr) refuse(type.no_other_view);
  return *view;
}

// Returns the command of a child that sees the inputs of jobs and the folder of its program, and writes to `folder`.
std::vector<std::string> confined(const JobRoots& roots, const std::string& folder, const std::string& program) {
  std::vector<std::string> words = {own_program(), "confined"};
  for (const std::string& root : roots.inputs.roots()) words.push_back("--read=" + root);
  words.insert(words.end(), {"--read=" + fs::path(program).parent_path().string(), "--write=" + folder, "--", program});
  return words;
}

}  // namespace

JobPictures::JobPictures(asio::io_context& io, DataFolder& data, const JobRoots& roots)
    : io_(io), data_(data), folder_(data.path() + "/pictures"), roots_(roots), one_at_a_time_(pool_.get_executor()) {
  make_folder(folder_);
  // If an earlier daemon could not make a view, it is tried once more, because the cause of the failure may be gone.
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored)) {
    if (id_of(entry.path().filename()) == 0 || !has_view(entry.path())) fs::remove_all(entry.path(), ignored);
  }
}

JobPictures::~JobPictures() {
  is_ending_ = true;
  pool_.join();
}

asio::awaitable<HttpResponse> JobPictures::answer(Job job, std::string name) {
  const JobView& view = find_view(job, name);
  std::string file_name = job.result_identity;
  std::replace(file_name.begin(), file_name.end(), ':', '-');
  const std::string folder = fmt::format("{}/{}-{}{}", folder_, job.id, file_name, view.folder_ending);
  // The variable has a name, because GCC 12 destroys a temporary twice if it is made in braces within a co_await.
  Request request{std::move(job), folder, view};
  co_await made(std::move(request));
  HttpResponse response{200, "image/png", ""};
  response.headers = {{"Cache-Control", "private, no-cache"}};
  if (is_page(name)) {
    response.content_type = "text/html; charset=utf-8";
    response.headers.emplace_back("Content-Security-Policy", kPagePolicy);
    response.headers.emplace_back("Referrer-Policy", "no-referrer");
  }
  OpenFile picture(::open((folder + "/" + name).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (picture.is_open()) {
    response.file = std::make_shared<OpenFile>(std::move(picture));
    co_return response;
  }
  const std::string why = last_line(folder + "/" + kSaid);
  refuse(why.empty() ? "there is nothing to compare with" : why);
}

asio::awaitable<void> JobPictures::made(Request request) {
  if (waiters_.size() >= kWaitingMax)
    throw Refusal{503, "busy", "too many jobs are waiting for pictures", {{"Retry-After", "10"}}};
  std::exception_ptr error;
  const auto initiate = [&](auto handler) {
    const auto shared = std::make_shared<decltype(handler)>(std::move(handler));
    const std::string folder = request.folder;
    std::vector<Waiter>& waiters = waiters_[folder];
    waiters.push_back([shared, &error](const std::exception_ptr& failed) {
      error = failed;
      (*shared)();
    });
    if (waiters.size() > 1) return;
    const auto done = [this, folder](const std::exception_ptr& failed) {
      asio::post(io_, [this, folder, failed] {
        for (const Waiter& waiter : std::exchange(waiters_[folder], {})) waiter(failed);
        waiters_.erase(folder);
      });
    };
    asio::post(pool_, [this, done, request] {
      // Requests for existing pictures do not wait for pictures that are being made.
      try {
        if (has_result(request) && is_made(request)) return done(nullptr);
      } catch (const std::exception&) {  // make() will find the same error
      }
      asio::post(one_at_a_time_, [this, done, request] {
        try {
          make(request);
          done(nullptr);
        } catch (...) {
          done(std::current_exception());
        }
      });
    });
  };
  co_await asio::async_initiate<const asio::use_awaitable_t<>, void()>(initiate, use_awaitable);
  if (error) std::rethrow_exception(error);
}

// Returns the options for the job's maps that still exist.
std::vector<std::string> JobPictures::map_options(const Request& request) const {
  const nlohmann::json parameters = nlohmann::json::parse(request.job.parameters);
  const JobView& view = request.view;
  std::vector<std::string> options;
  for (const auto& [parameter, option] : view.maps) {
    if (!parameters.contains(parameter)) continue;
    try {
      options.push_back(option + "=" + roots_.inputs.input(path_of_text(parameters.at(parameter).get<std::string>())));
    } catch (const Error& error) {
      if (parameter != view.maps.front().first) continue;
      if (!view.first_map_is_for.empty()) refuse(view.first_map_is_for + ": " + error.what());
      break;  // the map is missing, so only the render remains
    }
  }
  return options;
}

std::vector<std::string> JobPictures::command(const Request& request, const std::string& folder) const {
  const JobView& view = request.view;
  const std::string program = view.program.empty() ? own_program() : find_program(view.program);
  std::vector<std::string> words = confined(roots_, folder, program);
  words.insert(words.end(), view.words.begin(), view.words.end());
  words.push_back("--output=" + (view.writes_folder ? folder : folder + "/" + view.files.front()));
  if (view.takes_roots)
    for (const std::string& root : roots_.inputs.roots()) words.push_back("--root=" + root);
  const std::vector<std::string> maps = map_options(request);
  words.insert(words.end(), maps.begin(), maps.end());
  words.insert(words.end(), {"--", request.job.output});
  return words;
}

bool JobPictures::has_result(const Request& request) const {
  return is_as_made(roots_.outputs, request.job.output, request.job.result_identity, roots_.seal);
}

// Lists the identities of the job's maps. The word "gone" stands for a map that no longer exists.
std::string JobPictures::sources_of(const Request& request) const {
  std::string text;
  const nlohmann::json parameters = nlohmann::json::parse(request.job.parameters);
  for (const auto& [parameter, option] : request.view.maps) {
    if (!parameters.contains(parameter)) continue;
    std::string identity = "gone";
    try {
      identity = file_identity(roots_.inputs.input(path_of_text(parameters.at(parameter).get<std::string>())));
    } catch (const Error&) {
    }
    text += fmt::format("{} {}\n", parameter, identity);
  }
  return text;
}

bool JobPictures::is_made(const Request& request) const {
  std::ifstream file(request.folder + "/" + kSources, std::ios::binary);
  const std::string sources{std::istreambuf_iterator<char>(file), {}};
  return !file.fail() && sources == sources_of(request);
}

void JobPictures::remove_folder(const std::string& folder) {
  const std::int64_t bytes = bytes_on_disk(folder);
  std::error_code error;
  if (fs::remove_all(folder, error) > 0 && !error) data_.give_back(bytes);
}

void JobPictures::make(const Request& request) {
  const auto check_result = [&] {
    if (!has_result(request)) refuse("its result has been changed or removed");
  };
  check_result();
  if (is_made(request)) return;
  remove_folder(request.folder);  // the pictures were made from other maps
  data_.check_room(1);
  make_folder(folder_);  // the folder may have been removed
  const std::string unfinished = folder_ + "/unfinished";
  std::error_code error;
  fs::remove_all(unfinished, error);
  fs::create_directory(unfinished, error);
  if (error) throw Error(ErrorCode::kEnvironment, unfinished + ": cannot be created: " + error.message());
  try {
    run(request, unfinished);
    check_result();
    publish(unfinished, request.folder);
  } catch (...) {
    fs::remove_all(unfinished, error);
    throw;
  }
  if (request.view.kept_max > 0) remove_oldest(request.view);
}

void JobPictures::publish(const std::string& unfinished, const std::string& folder) {
  const std::int64_t bytes = bytes_on_disk(unfinished);
  data_.take_room(bytes);
  std::error_code error;
  fs::rename(unfinished, folder, error);
  if (!error) return;
  data_.give_back(bytes);
  throw Error(ErrorCode::kEnvironment, folder + ": cannot be renamed to its final name: " + error.message());
}

void JobPictures::run(const Request& request, const std::string& folder) {
  const JobView& view = request.view;
  // This file is written before the maps are read, so that the view is made again if a map changes afterwards.
  write_text_file(folder + "/" + kSources, sources_of(request));
  const std::vector<std::string> words = command(request, folder);
  ChildLimits limits{kTimeMax, kNiceness, kMemoryMax};
  limits.is_cancelled = [this] { return is_ending_.load(); };
  const ChildResult result = run_child(words, limits);
  if (is_ending_) refuse("the service is about to stop");
  std::string said = result.output + end_of(result, view.program.empty() ? "multum " + view.words[0] : view.program);
  const auto is_first_map = [&](const std::string& word) { return word.starts_with(view.maps.front().second + "="); };
  const bool has_input = view.maps.empty() || std::any_of(words.begin(), words.end(), is_first_map);
  if (!has_input && result.exit_code == 0) said += "\nits input no longer exists";
  write_text_file(folder + "/" + kSaid, said + "\n");
  if (result.exit_code != 0)
    service_log(LogSeverity::kWarning, request.job.id, "pictures: " + last_line(folder + "/" + kSaid));
}

void JobPictures::remove_oldest(const JobView& view) {
  std::vector<std::pair<fs::file_time_type, fs::path>> made;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored))
    if (entry.path().filename().string().ends_with(view.folder_ending))
      made.emplace_back(entry.last_write_time(ignored), entry.path());
  std::sort(made.rbegin(), made.rend());
  for (std::size_t i = view.kept_max; i < made.size(); ++i) remove_folder(made[i].second.string());
}

void JobPictures::remove(const std::vector<std::int64_t>& ids) {
  if (ids.empty()) return;
  const std::set<std::int64_t> gone(ids.begin(), ids.end());
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored))
    if (gone.contains(id_of(entry.path().filename()))) remove_folder(entry.path().string());
}

void JobPictures::sweep(QueueThread& ledger) {
  asio::post(pool_, [this, &ledger] {
    const auto ids = std::make_shared<std::vector<std::int64_t>>();
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored))
      if (const std::int64_t id = id_of(entry.path().filename()); id != 0) ids->push_back(id);
    // Posted to io_, whose thread ends before the ledger.
    asio::post(io_, [this, &ledger, ids] {
      ledger.run(
          [ids](JobQueue& queue) { std::erase_if(*ids, [&](std::int64_t id) { return !queue.was_purged(id); }); },
          [this, ids](const std::exception_ptr& error) {
            if (!error) asio::post(pool_, [this, ids] { remove(*ids); });
          });
    });
  });
}

}  // namespace multum
