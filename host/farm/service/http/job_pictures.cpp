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
#include "host/farm/service/service_log.h"
#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;
using asio::use_awaitable;

constexpr auto kTimeMax = std::chrono::seconds(60);
constexpr int kNiceness = 10;  // jobs go before
constexpr std::uint64_t kMemoryMax = std::uint64_t{3} << 30;
constexpr std::size_t kLooksMax = 16;  // pages that are kept; one of the largest map that they show is 37 MB
constexpr char kSaid[] = "said.txt", kSources[] = "sources.txt", kPlayer[] = "player.html", kLook[] = "look.html";
constexpr char kLookEnding[] = "-look";
// Such a page has all in itself. It may run its own script and save paths, and is of no origin: what a stranger may
// have done to it reaches neither the service nor a token.
constexpr char kPagePolicy[] =
    "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; "
    "worker-src blob:; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'";
constexpr std::size_t kReasonMax = 400;  // bytes
constexpr std::size_t kWaitingMax = 64;  // jobs: a minute or so, as a rule

[[noreturn]] void refuse(const std::string& why) { throw Refusal{404, "no_picture", why}; }

// Beside this program, else in PATH; empty: nowhere.
std::string find_viewer() {
  std::vector<fs::path> folders = {own_folder()};
  const char* path = std::getenv("PATH");
  for (std::string_view rest = path != nullptr ? path : ""; !rest.empty();) {
    const std::string_view one = rest.substr(0, rest.find(':'));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    if (!one.empty()) folders.emplace_back(one);
  }
  for (const fs::path& folder : folders)
    if (::access((folder / "multum-view").c_str(), X_OK) == 0) return (folder / "multum-view").string();
  return "";
}

std::string last_line(const std::string& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) last = line;
  return last.substr(0, kReasonMax);
}

// The number that a folder's name begins with; 0: none.
std::int64_t id_of(const std::string& name) {
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
  return error == std::errc() && end != name.data() + name.size() && *end == '-' ? id : 0;
}

std::string end_of(const ChildResult& result, const char* program) {
  if (result.is_over_time) return fmt::format("{} took more than {} s and was killed", program, kTimeMax.count());
  if (result.signal != 0) return fmt::format("{} was ended by signal {}", program, result.signal);
  return "";  // it has said what was wrong
}

void check_has_picture(const Job& job, const std::string& name) {
  if (job.type != "bake" && job.type != "infer" && job.type != "pack")
    refuse("a " + job.type + " makes nothing to look at");
  if (job.state != JobState::kSucceeded)
    refuse(fmt::format("job {} is {}: there are pictures when it has succeeded", job.id, job_state_name(job.state)));
  if (job.type == "infer" && name != "render.png") refuse("there is a picture of its first frame alone");
  if (job.type == "pack" && name != kPlayer) refuse("there is a player of it, and no pictures");
  if (job.type == "bake" && name == kPlayer) refuse("packed fields alone have a player");
}

// A child that sees what jobs may read and what is beside its program, and writes to `folder`.
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
  // What an earlier daemon could not make is tried once more: by now there may be what it lacked.
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored)) {
    const auto has = [&](const char* name) { return fs::exists(entry.path() / name, ignored); };
    if (id_of(entry.path().filename()) == 0 || (!has("render.png") && !has(kPlayer) && !has(kLook)))
      fs::remove_all(entry.path(), ignored);
  }
}

JobPictures::~JobPictures() {
  is_ending_ = true;
  pool_.join();
}

asio::awaitable<HttpResponse> JobPictures::answer(Job job, std::string identity, std::string name) {
  check_has_picture(job, name);
  std::string file_name = identity;
  std::replace(file_name.begin(), file_name.end(), ':', '-');
  const bool is_look = name == kLook;
  const std::string folder = fmt::format("{}/{}-{}{}", folder_, job.id, file_name, is_look ? kLookEnding : "");
  // Named: GCC 12 destroys what is made in braces within a co_await twice.
  Request request{std::move(job), std::move(identity), folder, is_look};
  co_await made(std::move(request));
  HttpResponse response{200, "image/png", ""};
  response.headers = {{"Cache-Control", "private, no-cache"}};
  if (name == kPlayer || is_look) {
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
    throw Refusal{503, "busy", "pictures of many jobs are being made", {{"Retry-After", "10"}}};
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
      // Pictures that are there are not kept waiting by those that are being made.
      try {
        if (has_result(request) && is_made(request)) return done(nullptr);
      } catch (const std::exception&) {  // whoever makes them finds it too
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

std::vector<std::string> JobPictures::look_command(const Job& job, const std::string& folder) const {
  std::string source;
  try {
    source = roots_.inputs.input(path_of_text(nlohmann::json::parse(job.parameters).at("input").get<std::string>()));
  } catch (const Error& error) {
    refuse(std::string("the page shows the lobes beside the map that was baked: ") + error.what());
  }
  std::vector<std::string> words = confined(roots_, folder, own_program());
  words.insert(words.end(), {"look", "-q", "--no-open", "--same-source", "--source=" + source, "-o",
                             folder + "/" + kLook, "--", job.output});
  return words;
}

std::vector<std::string> JobPictures::command(const Request& request, const std::string& folder) const {
  const Job& job = request.job;
  if (request.is_look) return look_command(job, folder);
  if (job.type == "pack") {
    std::vector<std::string> words = confined(roots_, folder, own_program());
    words.insert(words.end(), {"player", "-q", "-o", folder + "/" + kPlayer});
    for (const std::string& root : roots_.inputs.roots()) words.push_back("--root=" + root);
    words.insert(words.end(), {"--", job.output});
    return words;
  }
  const std::string viewer = find_viewer();
  if (viewer.empty()) refuse("multum-view is not installed: found neither beside multum nor in PATH");
  std::vector<std::string> words = confined(roots_, folder, viewer);
  // Not the GPU, which bakes may be using.
  words.insert(words.end(), {"thumbnails", "--context=osmesa", "--output=" + folder});
  const nlohmann::json parameters = nlohmann::json::parse(job.parameters);
  for (const auto& [parameter, option] : {std::pair("input", "--source="), std::pair("albedo", "--albedo=")}) {
    if (job.type != "bake" || !parameters.contains(parameter)) continue;
    try {
      words.push_back(option + roots_.inputs.input(path_of_text(parameters.at(parameter).get<std::string>())));
    } catch (const Error&) {
      if (std::string(parameter) == "input") break;  // gone: the render is left
    }
  }
  words.insert(words.end(), {"--", job.output});
  return words;
}

bool JobPictures::has_result(const Request& request) const {
  return is_as_made(roots_.outputs, request.job.output, request.identity, roots_.seal);
}

// By what the maps that the job was given are told from others; of one that is not there any more a word.
std::string JobPictures::sources_of(const Job& job) const {
  std::string text;
  if (job.type != "bake") return text;
  const nlohmann::json parameters = nlohmann::json::parse(job.parameters);
  for (const char* parameter : {"input", "albedo"}) {
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
  return !file.fail() && sources == sources_of(request.job);
}

void JobPictures::remove_folder(const std::string& folder) {
  const std::int64_t bytes = bytes_on_disk(folder);
  std::error_code error;
  if (fs::remove_all(folder, error) > 0 && !error) data_.give_back(bytes);
}

void JobPictures::make(const Request& request) {
  const auto check_result = [&] {
    if (!has_result(request)) refuse("its result was changed or taken away since");
  };
  check_result();
  if (is_made(request)) return;
  remove_folder(request.folder);  // of other maps
  data_.check_room(1);
  make_folder(folder_);  // somebody may have removed it
  const std::string unfinished = folder_ + "/unfinished";
  std::error_code error;
  fs::remove_all(unfinished, error);
  fs::create_directory(unfinished, error);
  if (error) throw Error(ErrorCode::kEnvironment, unfinished + ": cannot be made: " + error.message());
  try {
    run(request, unfinished);
    check_result();
    publish(unfinished, request.folder);
  } catch (...) {
    fs::remove_all(unfinished, error);
    throw;
  }
  if (request.is_look) remove_old_looks();
}

void JobPictures::publish(const std::string& unfinished, const std::string& folder) {
  const std::int64_t bytes = bytes_on_disk(unfinished);
  data_.take_room(bytes);
  std::error_code error;
  fs::rename(unfinished, folder, error);
  if (!error) return;
  data_.give_back(bytes);
  throw Error(ErrorCode::kEnvironment, folder + ": cannot be given its name: " + error.message());
}

void JobPictures::run(const Request& request, const std::string& folder) {
  const Job& job = request.job;
  write_text_file(folder + "/" + kSources, sources_of(job));  // before they are read: what changes then is made again
  const std::vector<std::string> words = command(request, folder);
  ChildLimits limits{kTimeMax, kNiceness, kMemoryMax};
  limits.is_cancelled = [this] { return is_ending_.load(); };
  const ChildResult result = run_child(words, limits);
  if (is_ending_) refuse("the service is about to end");
  const char* program = request.is_look ? "multum look" : job.type == "pack" ? "multum player" : "multum-view";
  std::string said = result.output + end_of(result, program);
  const bool has_input = job.type != "bake" || std::any_of(words.begin(), words.end(), [](const std::string& word) {
                           return word.starts_with("--source=");
                         });
  if (!has_input && result.exit_code == 0) said += "\nits input is not there any more";
  write_text_file(folder + "/" + kSaid, said + "\n");
  if (result.exit_code != 0) service_log(LogSeverity::kWarning, job.id, "pictures: " + last_line(folder + "/" + kSaid));
}

void JobPictures::remove_old_looks() {
  std::vector<std::pair<fs::file_time_type, fs::path>> looks;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored))
    if (entry.path().filename().string().ends_with(kLookEnding))
      looks.emplace_back(entry.last_write_time(ignored), entry.path());
  std::sort(looks.rbegin(), looks.rend());
  for (std::size_t i = kLooksMax; i < looks.size(); ++i) remove_folder(looks[i].second.string());
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
    // By way of io_, whose thread the ledger outlives.
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
