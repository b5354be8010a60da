// SPDX-License-Identifier: Apache-2.0
// Small pictures of finished jobs, and pages that show their results in a browser: the views of the job's type
// (workers/job_types.h). A child process makes them, one at a time, when they are first asked for. What a map or a
// driver does to it ends that child, and pictures are missing.
//
//   DATA/pictures/ID-IDENTITYENDING/   render.png, player.html ...   those files of the view that could be made
//                                      said.txt                      what the child said; how it ended, if not well
//                                      sources.txt                   identities of the maps that it was given
//
// IDENTITY is that of the result as it was published (staging.h): the pictures of another result are never shown, and
// those that show a map are made again when it has changed. All of it counts against data_max. Of views that
// are large, as pages with maps in them are, those made last are kept, the others are made again when they are asked
// for.
#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "host/farm/service/files/data_folder.h"
#include "host/farm/service/files/job_roots.h"
#include "host/farm/service/http/http_server.h"
#include "host/farm/service/ledger/job.h"
#include "host/farm/service/ledger/queue_thread.h"
#include "host/farm/service/workers/job_types.h"

namespace multum {

class JobPictures {
 public:
  /// `data`: the daemon's. Answers on the thread of `io`; files and children are for threads of its own.
  JobPictures(boost::asio::io_context& io, DataFolder& data, const JobRoots& roots);
  /// Ends the child that is at work.
  ~JobPictures();
  JobPictures(const JobPictures&) = delete;
  JobPictures& operator=(const JobPictures&) = delete;

  /// `name`: of a file of one of the type's views, as "render.png". Many may ask at once: the first has them
  /// made, all wait. Throws Refusal 404 "no_picture" with the reason, 507 "quota" where data_max has no room for them.
  boost::asio::awaitable<HttpResponse> answer(Job job, std::string name);

  /// Blocks.
  void remove(const std::vector<std::int64_t>& ids);
  /// Removes those of jobs that are in no ledger any more: a daemon may have died between purging and removing, or
  /// pictures may have been in the making.
  void sweep(QueueThread& ledger);

 private:
  struct Request {
    Job job;
    std::string folder;
    const JobView& view;
  };
  boost::asio::awaitable<void> made(Request request);
  void make(const Request& request);
  void run(const Request& request, const std::string& folder);
  void publish(const std::string& unfinished, const std::string& folder);
  void remove_folder(const std::string& folder);
  std::string sources_of(const Request& request) const;
  bool has_result(const Request& request) const;
  bool is_made(const Request& request) const;
  std::vector<std::string> command(const Request& request, const std::string& folder) const;
  std::vector<std::string> map_options(const Request& request) const;
  void remove_oldest(const JobView& view);

  boost::asio::io_context& io_;
  DataFolder& data_;
  const std::string folder_;
  const JobRoots& roots_;
  std::atomic<bool> is_ending_ = false;
  /// By folder: who waits for it. On the thread of io_.
  using Waiter = std::function<void(std::exception_ptr)>;
  std::map<std::string, std::vector<Waiter>> waiters_;
  boost::asio::thread_pool pool_{2};  // one may be at work with a child, the other looks what is there
  boost::asio::strand<boost::asio::thread_pool::executor_type> one_at_a_time_;
};

}  // namespace multum
