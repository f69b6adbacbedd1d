// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/cluster/mpi_ranks.h>

#include <stdexcept>

#ifdef PCL_SSFR_WITH_MPI
#include <boost/mpi.hpp>

#include <array>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <set>
#include <thread>
#include <utility>
#endif

namespace pcl_ssfr {
namespace apps {

#ifdef PCL_SSFR_WITH_MPI

namespace {

namespace mpi = boost::mpi;

enum Tag { kReady = 1, kTask, kMessage, kFailed, kStop, kEnd };
constexpr std::chrono::milliseconds kIdle(2); // MPI's own waiting takes a whole processor
constexpr int kFailedExit = 3;                // of a rank that could not say what is wrong

/// Variables that the starters of MPI pass to their children, for a rank and for the number of ranks: Open MPI, MPICH
/// and Intel MPI, Slurm's PMIx.
constexpr std::array<std::pair<const char*, const char*>, 4> kStarters = {
    {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
     {"PMI_RANK", "PMI_SIZE"},
     {"PMI_RANK", "MPI_LOCALNRANKS"},
     {"PMIX_RANK", "SLURM_STEP_NUM_TASKS"}}};

/// This rank and their number; 0 of 1 when nobody says so.
std::pair<int, int>
launchedRank()
{
  for (const auto& [rank, size] : kStarters) {
    const char* count = std::getenv(size);
    if (const char* number = std::getenv(rank); number && count)
      return {std::atoi(number), std::atoi(count)};
  }
  return {0, 1};
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

void
doNothing()
{}

} // namespace

struct MpiRanks::Impl {
  // An exception on its way must not abort the job: the destructor of MpiRanks ends it in peace.
  mpi::environment environment{mpi::threading::funneled, false};
  mpi::communicator world;
  std::set<int> waiting; ///< at rank 0: ranks that have no task
  bool is_over = false;  ///< at the others: rank 0 said so
};

bool
MpiRanks::areLaunched()
{
  return launchedRank().second > 1;
}

bool
MpiRanks::isFirst()
{
  return launchedRank().first == 0;
}

MpiRanks::MpiRanks() : impl_(std::make_unique<Impl>())
{}

MpiRanks::~MpiRanks()
{
  if (rank() > 0 && !impl_->is_over)
    mpi::environment::abort(kFailedExit);
  try {
    if (rank() > 0)
      return;
    deal([](int) { return std::nullopt; }, [](const std::string&) {}, doNothing);
    for (const int other : impl_->waiting)
      impl_->world.send(other, kEnd, std::string());
  }
  catch (...) {
    mpi::environment::abort(kFailedExit);
  }
}

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

void
MpiRanks::deal(const Next& next, const OnMessage& on_message, const std::function<void()>& on_idle)
{
  const mpi::communicator& world = impl_->world;
  std::set<int>& waiting = impl_->waiting;
  std::exception_ptr failure; // thrown once nobody works any more
  const auto guarded = [&](const auto& call) {
    if (failure)
      return;
    try {
      call();
    }
    catch (...) {
      failure = std::current_exception();
      for (int other = 1; other < count(); ++other)
        if (waiting.count(other) == 0)
          world.send(other, kStop, std::string());
    }
  };
  const auto give = [&](int other) {
    std::optional<std::string> task;
    waiting.insert(other);
    guarded([&] { task = next(other); });
    if (!task)
      return;
    world.send(other, kTask, *task);
    waiting.erase(other);
  };
  for (const int other : std::set<int>(waiting))
    give(other);
  while (waiting.size() + 1 < static_cast<std::size_t>(count())) {
    const mpi::status status = await(world, on_idle);
    std::string message;
    world.recv(status.source(), status.tag(), message);
    if (status.tag() == kReady)
      give(status.source());
    else if (status.tag() == kMessage)
      guarded([&] { on_message(message); });
    else
      guarded([&] { throw std::runtime_error(message); });
  }
  if (failure)
    std::rethrow_exception(failure);
}

void
MpiRanks::work(const std::function<void(const std::string& task, const Send& send)>& run)
{
  const mpi::communicator& world = impl_->world;
  for (;;) {
    world.send(0, kReady, std::string());
    std::string task;
    int tag = kStop; // it may come after the task is done: it is for none then
    while (tag == kStop) {
      tag = await(world, doNothing).tag();
      world.recv(0, tag, task);
    }
    if (tag == kEnd) {
      impl_->is_over = true;
      return;
    }
    std::string problem;
    try {
      run(task, [&world](const std::string& message) { world.send(0, kMessage, message); });
      continue;
    }
    catch (const std::exception& error) {
      problem = error.what();
    }
    catch (...) {
      problem = "unknown exception";
    }
    world.send(
        0, kFailed, "rank " + std::to_string(rank()) + " on " + mpi::environment::processor_name() + ": " + problem);
  }
}

bool
MpiRanks::isStopped() const
{
  return impl_->world.iprobe(0, kStop).has_value();
}

#else

struct MpiRanks::Impl {};

bool
MpiRanks::areLaunched()
{
  return false;
}

bool
MpiRanks::isFirst()
{
  return true;
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

void
MpiRanks::deal(const Next&, const OnMessage&, const std::function<void()>&)
{}

void
MpiRanks::work(const std::function<void(const std::string& task, const Send& send)>&)
{}

bool
MpiRanks::isStopped() const
{
  return false;
}

#endif

} // namespace apps
} // namespace pcl_ssfr
