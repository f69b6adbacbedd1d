// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/child_process.h>

#include <apps/common/seconds_since.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <poll.h>
#include <sstream>
#include <string_view>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace pcl_ssfr {
namespace apps {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kKeptOutput = 1U << 20; ///< bytes of standard output; a result is its last line
constexpr std::size_t kKeptErrors = 1U << 12;
constexpr std::size_t kTakenAtOnce = 1U << 20; ///< bytes between looks at the time limits
constexpr int kPollMilliseconds = 20;
constexpr double kCpuPollSeconds = 0.1; ///< between looks at the processor time
constexpr int kMaxDepth = 100;          ///< of a tree of processes
constexpr double kKibPerMib = 1024;

/// A file descriptor that closes itself.
class Descriptor {
public:
  explicit Descriptor(int value = -1) : value_(value) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor&
  operator=(const Descriptor&) = delete;

  int
  get() const
  {
    return value_;
  }
  void
  reset(int value)
  {
    close();
    value_ = value;
  }
  void
  close()
  {
    if (value_ >= 0)
      ::close(value_);
    value_ = -1;
  }

private:
  int value_;
};

struct Pipe {
  Descriptor read;
  Descriptor write;

  bool
  open()
  {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0)
      return false;
    read.reset(ends[0]);
    write.reset(ends[1]);
    return true;
  }
};

/// Where a shell would find a program; empty when nowhere.
std::string
findProgram(const std::string& name)
{
  if (name.find('/') != std::string::npos)
    return name;
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::string candidate = (folder.empty() ? "." : folder) + "/" + name;
    if (access(candidate.c_str(), X_OK) == 0)
      return candidate;
  }
  return {};
}

bool
isMpiVariable(std::string_view variable)
{
  for (const std::string_view prefix : {"OMPI_", "PMIX_", "PMI_", "PRTE_", "OMP_NUM_THREADS="})
    if (variable.substr(0, prefix.size()) == prefix)
      return true;
  return false;
}

/// The environment of a child: it is no rank, and has its number of threads.
std::vector<std::string>
childEnvironment(unsigned threads)
{
  std::vector<std::string> variables;
  for (char** variable = environ; variable && *variable; ++variable)
    if (!isMpiVariable(*variable))
      variables.emplace_back(*variable);
  if (threads > 0)
    variables.push_back("OMP_NUM_THREADS=" + std::to_string(threads));
  return variables;
}

std::vector<char*>
pointers(std::vector<std::string>& texts)
{
  std::vector<char*> result;
  result.reserve(texts.size() + 1);
  for (std::string& text : texts)
    result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

/// Memory of another process since its program began [MiB].
double
memoryOf(const std::string& process)
{
  std::ifstream status("/proc/" + process + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmHWM:", 0) == 0)
      return std::strtod(line.c_str() + 6, nullptr) / kKibPerMib;
  return 0;
}

/** \brief Processor time of another process, of the children that it waited for and of those that still run [s]. What
 * leaves the tree, a child whose parent ended before it, is not seen.
 */
double
cpuSecondsOf(pid_t process, int depth = 0)
{
  const std::string folder = "/proc/" + std::to_string(process);
  std::ifstream stat(folder + "/stat");
  std::string line;
  std::getline(stat, line);
  const std::size_t name_end = line.rfind(')'); // a name may hold anything
  if (name_end == std::string::npos)
    return 0;
  std::istringstream fields(line.substr(name_end + 1));
  constexpr int kFieldsBefore = 11; // from the state to what precedes utime, stime, cutime, cstime
  std::string skipped;
  for (int i = 0; i < kFieldsBefore; ++i)
    fields >> skipped;
  double ticks = 0;
  for (double value = 0, i = 0; i < 4 && fields >> value; ++i)
    ticks += value;
  double seconds = ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
  if (depth == kMaxDepth)
    return seconds;
  std::error_code error; // the process may end while it is looked at
  for (std::filesystem::directory_iterator task(folder + "/task", error), end; !error && task != end;
       task.increment(error)) {
    std::ifstream children(task->path() / "children");
    for (pid_t child = 0; children >> child;)
      seconds += cpuSecondsOf(child, depth + 1);
  }
  return seconds;
}

/// Read what is there, a part of it where more comes all the time; false at the end of the file.
bool
drain(int descriptor, std::string& text, std::size_t kept)
{
  std::array<char, 1U << 16> buffer{};
  for (std::size_t taken = 0; taken < kTakenAtOnce;) {
    const ssize_t got = read(descriptor, buffer.data(), buffer.size());
    if (got == 0)
      return false;
    if (got < 0)
      return errno == EAGAIN || errno == EINTR;
    taken += static_cast<std::size_t>(got);
    text.append(buffer.data(), static_cast<std::size_t>(got));
    if (text.size() > 2 * kept)
      text.erase(0, text.size() - kept);
  }
  return true;
}

/// One run of a child.
class Child {
public:
  explicit Child(const ChildRequest& request) : request_(request) {}

  ChildOutcome
  run(const std::atomic<int>& stop)
  {
    if (!start())
      return outcome_;
    while (!ended_) {
      exchange();
      reap(WNOHANG);
      if (ended_)
        break;
      if (stop.load() != 0)
        end(ChildOutcome::End::Stopped);
      else if (isOverdue())
        end(ChildOutcome::End::TimedOut);
      else if (hasUsedUp())
        end(ChildOutcome::End::CpuTimedOut);
    }
    drain(output_.read.get(), outcome_.output, kKeptOutput);
    drain(errors_.read.get(), outcome_.errors, kKeptErrors);
    kill(-process_, SIGKILL); // whatever it left behind
    outcome_.seconds = secondsSince(began_);
    // The kernel does not count the children of a killed child that nobody waited for.
    outcome_.cpu_seconds = std::max(outcome_.cpu_seconds, sampled_cpu_) - cpu_at_began_;
    // A child is born with the memory of its parent: where that is all that the kernel counted, its own was sampled.
    if (outcome_.peak_rss_mib <= memory_at_start_ * 1.05 && sampled_memory_ > 0)
      outcome_.peak_rss_mib = sampled_memory_;
    return outcome_;
  }

private:
  bool
  failed(int error)
  {
    outcome_.end = ChildOutcome::End::NotStarted;
    outcome_.code = error;
    return false;
  }

  bool
  start()
  {
    const std::string program = request_.command.empty() ? "" : findProgram(request_.command.front());
    if (program.empty())
      return failed(ENOENT);
    Pipe failure;
    if (!input_.open() || !output_.open() || !errors_.open() || !failure.open())
      return failed(errno);
    std::vector<std::string> words = request_.command;
    std::vector<std::string> variables = childEnvironment(request_.threads);
    const std::vector<char*> arguments = pointers(words);
    const std::vector<char*> environment = pointers(variables);
    memory_at_start_ = peakMemoryMib();
    began_ = Clock::now();
    const pid_t parent = getpid();
    process_ = fork();
    if (process_ < 0)
      return failed(errno);
    if (process_ == 0) { // only calls that are safe between fork and exec
      setpgid(0, 0);
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent)
        _exit(1);
      dup2(input_.read.get(), STDIN_FILENO);
      dup2(output_.write.get(), STDOUT_FILENO);
      dup2(errors_.write.get(), STDERR_FILENO);
      for (const int number : {SIGINT, SIGTERM, SIGPIPE, SIGHUP})
        signal(number, SIG_DFL);
      execve(program.c_str(), arguments.data(), environment.data());
      const int error = errno;
      const ssize_t ignored = write(failure.write.get(), &error, sizeof(error));
      _exit(ignored > 0 ? 127 : 126);
    }
    setpgid(process_, process_); // whoever comes first
    for (Pipe* pipe : {&output_, &errors_, &failure})
      pipe->write.close();
    input_.read.close();
    int error = 0;
    if (read(failure.read.get(), &error, sizeof(error)) == sizeof(error)) {
      reap(0);
      return failed(error);
    }
    for (const int descriptor : {input_.write.get(), output_.read.get(), errors_.read.get()})
      fcntl(descriptor, F_SETFL, O_NONBLOCK);
    return true;
  }

  /// Feed the input and take the output, for a moment.
  void
  exchange()
  {
    if (written_ == request_.input.size())
      input_.write.close();
    std::array<pollfd, 3> watched{
        {{output_.read.get(), POLLIN, 0}, {errors_.read.get(), POLLIN, 0}, {input_.write.get(), POLLOUT, 0}}};
    poll(watched.data(), watched.size(), kPollMilliseconds);
    if (watched[2].fd >= 0 && watched[2].revents != 0) {
      const ssize_t sent = write(watched[2].fd, request_.input.data() + written_, request_.input.size() - written_);
      if (sent > 0)
        written_ += static_cast<std::size_t>(sent);
      else if (sent < 0 && errno != EAGAIN && errno != EINTR)
        input_.write.close(); // it does not want to know
    }
    if (watched[0].fd >= 0 && !drain(watched[0].fd, outcome_.output, kKeptOutput))
      output_.read.close();
    if (watched[1].fd >= 0 && !drain(watched[1].fd, outcome_.errors, kKeptErrors))
      errors_.read.close();
    if (request_.loading_limit > 0 && !loaded_ && outcome_.output.find('\n') != std::string::npos) {
      loaded_ = true;
      began_ = Clock::now();
      cpu_at_began_ = cpuSecondsOf(process_);
    }
    sampled_memory_ = std::max(sampled_memory_, memoryOf(std::to_string(process_)));
    if (output_.read.get() < 0 && errors_.read.get() < 0)
      usleep(1000); // both closed: it ends soon, or it hides from us
  }

  bool
  isOverdue() const
  {
    const bool loading = request_.loading_limit > 0 && !loaded_;
    const double limit = loading ? request_.loading_limit : request_.time_limit;
    return limit > 0 && secondsSince(began_) > limit;
  }

  /// Whether its processor time is spent; looked up now and then only.
  bool
  hasUsedUp()
  {
    if (secondsSince(cpu_looked_) < kCpuPollSeconds)
      return false;
    cpu_looked_ = Clock::now();
    sampled_cpu_ = std::max(sampled_cpu_, cpuSecondsOf(process_));
    const bool loading = request_.loading_limit > 0 && !loaded_;
    return request_.cpu_limit > 0 && !loading && sampled_cpu_ - cpu_at_began_ > request_.cpu_limit;
  }

  void
  reap(int flags)
  {
    int status = 0;
    rusage usage{};
    if (wait4(process_, &status, flags, &usage) != process_)
      return;
    ended_ = true;
    if (!ending_) {
      outcome_.end = WIFEXITED(status) ? ChildOutcome::End::Exited : ChildOutcome::End::Signalled;
      outcome_.code = WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status);
    }
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    outcome_.cpu_seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    outcome_.peak_rss_mib = static_cast<double>(usage.ru_maxrss) / kKibPerMib;
  }

  /// Ask the group to end, then make it.
  void
  end(ChildOutcome::End why)
  {
    ending_ = true;
    outcome_.end = why;
    kill(-process_, SIGTERM);
    const auto asked = Clock::now();
    while (!ended_ && secondsSince(asked) < request_.grace) {
      exchange();
      reap(WNOHANG);
    }
    kill(-process_, SIGKILL);
    if (!ended_)
      reap(0);
  }

  const ChildRequest& request_;
  ChildOutcome outcome_;
  Pipe input_;
  Pipe output_;
  Pipe errors_;
  pid_t process_ = -1;
  Clock::time_point began_;
  Clock::time_point cpu_looked_;
  double cpu_at_began_ = 0; ///< processor time spent on loading [s]
  double sampled_cpu_ = 0;  ///< processor time when it was last looked at [s]
  std::size_t written_ = 0;
  bool loaded_ = false;
  bool ending_ = false;
  bool ended_ = false;
  double memory_at_start_ = 0;
  double sampled_memory_ = 0;
};

} // namespace

ChildOutcome
runChild(const ChildRequest& request, const std::atomic<int>& stop)
{
  return Child(request).run(stop);
}

void
adoptStrays()
{
  prctl(PR_SET_CHILD_SUBREAPER, 1);
}

void
killStrays()
{
  for (;;) {
    std::ifstream list("/proc/self/task/" + std::to_string(getpid()) + "/children");
    bool any = false;
    for (pid_t child = 0; list >> child;) {
      any = true;
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
    }
    if (!any)
      return;
  }
}

double
peakMemoryMib()
{
  return memoryOf("self");
}

std::string
signalName(int signal)
{
  const char* name = sigdescr_np(signal);
  return name ? name : "signal " + std::to_string(signal);
}

} // namespace apps
} // namespace pcl_ssfr
