// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/mpi_ranks.h>

#include <chrono>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <thread>

#ifdef PCL_SSFR_WITH_MPI
#include <boost/mpi.hpp>
#endif

namespace pcl_ssfr {
namespace apps {

#ifdef PCL_SSFR_WITH_MPI

namespace {

namespace mpi = boost::mpi;

enum Tag { kReady = 1, kTask, kEnd, kLine };
constexpr std::chrono::milliseconds kIdle(2); // MPI's own waiting takes a whole processor

/// Ranks of the job as the starters of MPI pass them to their children: Open MPI, MPICH and Intel MPI, Slurm's PMI.
int
launchedRanks()
{
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MPI_LOCALNRANKS"})
    if (const char* value = std::getenv(name))
      return std::atoi(value);
  return 1;
}

/// A message, without burning a processor while there is none.
mpi::status
await(const mpi::communicator& world, const std::function<void()>& on_idle)
{
  for (;;) {
    if (const auto status = world.iprobe(mpi::any_source, mpi::any_tag))
      return *status;
    on_idle();
    std::this_thread::sleep_for(kIdle);
  }
}

} // namespace

struct MpiRanks::Impl {
  mpi::environment environment{mpi::threading::funneled};
  mpi::communicator world;
};

bool
MpiRanks::areLaunched()
{
  return launchedRanks() > 1;
}

MpiRanks::MpiRanks() : impl_(std::make_unique<Impl>())
{}

MpiRanks::~MpiRanks() = default;

int
MpiRanks::rank() const
{
  return impl_->world.rank();
}

int
MpiRanks::count() const
{
  return impl_->world.size();
}

int
MpiRanks::fromFirst(int value) const
{
  mpi::broadcast(impl_->world, value, 0);
  return value;
}

void
MpiRanks::deal(const std::vector<std::string>& tasks,
               const std::function<void(const std::string& line)>& on_line,
               const std::function<void()>& on_idle,
               const std::atomic<int>& stop) const
{
  std::size_t next = 0;
  std::exception_ptr failure;
  for (int working = count() - 1; working > 0;) {
    const mpi::status status = await(impl_->world, on_idle);
    std::string message;
    impl_->world.recv(status.source(), status.tag(), message);
    if (status.tag() == kLine) {
      try {
        if (!failure)
          on_line(message);
      }
      catch (...) { // thrown once nobody waits for an answer any more
        failure = std::current_exception();
      }
    }
    else if (next < tasks.size() && stop.load() == 0 && !failure) {
      impl_->world.send(status.source(), kTask, tasks[next++]);
    }
    else {
      impl_->world.send(status.source(), kEnd, std::string());
      --working;
    }
  }
  if (failure)
    std::rethrow_exception(failure);
}

void
MpiRanks::work(const std::function<void(const std::string& task, const Send& send)>& run) const
{
  for (;;) {
    impl_->world.send(0, kReady, std::string());
    const mpi::status status = await(impl_->world, [] {});
    std::string task;
    impl_->world.recv(0, status.tag(), task);
    if (status.tag() == kEnd)
      return;
    run(task, [this](const std::string& line) { impl_->world.send(0, kLine, line); });
  }
}

#else

struct MpiRanks::Impl {};

bool
MpiRanks::areLaunched()
{
  return false;
}

MpiRanks::MpiRanks()
{
  throw std::logic_error("this build has no MPI");
}

MpiRanks::~MpiRanks() = default;

int
MpiRanks::rank() const
{
  return 0;
}

int
MpiRanks::count() const
{
  return 1;
}

int
MpiRanks::fromFirst(int value) const
{
  return value;
}

void
MpiRanks::deal(const std::vector<std::string>&,
               const std::function<void(const std::string& line)>&,
               const std::function<void()>&,
               const std::atomic<int>&) const
{}

void
MpiRanks::work(const std::function<void(const std::string& task, const Send& send)>&) const
{}

#endif

} // namespace apps
} // namespace pcl_ssfr
