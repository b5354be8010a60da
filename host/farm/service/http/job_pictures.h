// SPDX-License-Identifier: Apache-2.0
// Makes small pictures of finished jobs, and pages that show their results in a browser. These are the views of the
// job's type (workers/job_types.h). A child process makes them, one at a time, at the first request. If a map or a
// driver crashes the child, only the pictures are missing.
//
//   DATA/pictures/ID-IDENTITYENDING/   render.png, player.html ...   files of the view that could be made
//                                      said.txt                      the child's output, and how it ended if it failed
//                                      sources.txt                   identities of the maps that the child was given
//
// IDENTITY is the identity of the published result (staging.h). Pictures of another result are never shown. Pictures
// that show a map are made again when the map has changed. All files count towards data_max. Of large views, such as
// pages that contain maps, only the newest are kept, and others are made again on request.
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

#include "host/farm/service/dispatch/data_folder.h"
#include "host/farm/service/files/job_roots.h"
#include "host/farm/service/http/http_server.h"
#include "host/farm/service/ledger/job.h"
#include "host/farm/service/ledger/queue_thread.h"
#include "host/farm/service/workers/job_types.h"

namespace multum {

class JobPictures {
 public:
  /// `data` is the daemon's folder. Answers on the thread of `io`, and uses separate threads for files and child
  /// processes.
  JobPictures(boost::asio::io_context& io, DataFolder& data, const JobRoots& roots);
  /// Ends the running child.
  ~JobPictures();
  JobPictures(const JobPictures&) = delete;
  JobPictures& operator=(const JobPictures&) = delete;

  /// `name` is a file of one of the type's views, such as "render.png". The first of several requests starts the child,
  /// and all requests wait for it. Throws Refusal 404 "no_picture" with the reason, and 507 "quota" if data_max leaves
  /// no room.
  boost::asio::awaitable<HttpResponse> answer(Job job, std::string name);

  /// Removes the pictures of these jobs. Blocks.
  void remove(const std::vector<std::int64_t>& ids);
  /// Removes pictures of jobs that are no longer in the ledger. Such pictures remain if a daemon died between purging
  /// and removing, or if pictures were made meanwhile.
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
  /// The waiting requests, by folder. They are used on the thread of io_.
  using Waiter = std::function<void(std::exception_ptr)>;
  std::map<std::string, std::vector<Waiter>> waiters_;
  boost::asio::thread_pool pool_{2};  // one thread may wait for a child, the other looks for existing files
  boost::asio::strand<boost::asio::thread_pool::executor_type> one_at_a_time_;
};

}  // namespace multum
