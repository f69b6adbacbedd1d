// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/benchmark/worker.h>

#include <apps/benchmark/lost_stage.h>
#include <apps/common/json_values.h>
#include <apps/common/utf8_text.h>
#include <apps/io/pcd_format.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <iostream>
#include <iterator>
#include <new>
#include <stdexcept>
#include <string_view>
#include <sys/resource.h>
#include <unistd.h>

namespace pcl_ssfr {
namespace apps {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kLoadingLimit = 600;          ///< of reading and varying a pair [s]
constexpr double kWatcherMargin = 10;          ///< that the watcher of an external program has after its time limit [s]
constexpr double kWatcherGrace = 3;            ///< that it has to end the program when it is asked to [s]
constexpr std::size_t kMessageLength = 200;    ///< of what a failed program said [bytes]
constexpr std::size_t kLongestText = 1U << 12; ///< of the message in the result of an external program [bytes]
constexpr const char* kPoseKeys[] = {"T_target_source", "T"}; ///< of the result of an external program

std::atomic<int> stop_requested{0}; // set by the signal handler of a watcher

// ---------------------------------------------------------------------------------------------------------------------
// The side that asks

/// The last non-blank line of what a program wrote, cut to a message.
std::string
lastLine(const std::string& text)
{
  const std::size_t end = text.find_last_not_of(" \t\r\n");
  if (end == std::string::npos)
    return {};
  const std::size_t before = text.find_last_of('\n', end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return std::string(utf8Prefix(std::string_view(text).substr(begin, end + 1 - begin), kMessageLength));
}

/// The last line that is a JSON object; of an event, when one is named.
Json
lastObject(const std::string& output, const char* event = nullptr)
{
  std::size_t end = output.size();
  while (end > 0) {
    const std::size_t before = output.find_last_of('\n', end - 1);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::string line = output.substr(begin, end - begin);
    if (line.find('{') != std::string::npos) {
      Json json = Json::parse(line, nullptr, false);
      if (json.is_object() && (!event || json.value("event", "") == event))
        return json;
    }
    if (before == std::string::npos)
      break;
    end = before;
  }
  return {};
}

std::string
ownProgram()
{
  std::array<char, 4096> path{};
  const ssize_t length = readlink("/proc/self/exe", path.data(), path.size() - 1);
  return length > 0 ? std::string(path.data(), static_cast<std::size_t>(length)) : std::string("ssfr_benchmark");
}

ChildOutcome
askWorker(const Json& request, double time_limit, double cpu_limit, unsigned threads, const std::atomic<int>& stop)
{
  ChildRequest child;
  child.command = {ownProgram(), kWorkerOption};
  Json::to_cbor(request, child.input); // unlike text, it keeps the bytes of paths that are no UTF-8
  child.time_limit = time_limit;
  child.cpu_limit = cpu_limit;
  child.loading_limit = kLoadingLimit;
  child.grace = kWatcherGrace;
  child.threads = threads;
  return runChild(child, stop);
}

/// What ended a process that gave no answer.
std::string
describeEnd(const ChildOutcome& outcome)
{
  const std::string said = lastLine(outcome.errors);
  std::string text;
  switch (outcome.end) {
  case ChildOutcome::End::Exited:
    text = "exit code " + std::to_string(outcome.code);
    break;
  case ChildOutcome::End::Signalled:
    text = signalName(outcome.code);
    break;
  case ChildOutcome::End::TimedOut:
  case ChildOutcome::End::CpuTimedOut:
    return "killed at the time limit";
  case ChildOutcome::End::Stopped:
    return "stopped";
  case ChildOutcome::End::NotStarted:
    return std::string("cannot be started: ") + std::strerror(outcome.code);
  }
  return said.empty() ? text : text + ": " + said;
}

/// The answer of a worker to a request that must not fail. \throw std::runtime_error
Json
askSurely(const Json& request, const char* what, const std::atomic<int>& stop)
{
  const ChildOutcome outcome = askWorker(request, kLoadingLimit, 0, 1, stop);
  Json reply = lastObject(outcome.output);
  const bool answered =
      reply.is_object() && outcome.end == ChildOutcome::End::Exited && reply.value("event", "") == "done";
  if (!answered || reply.contains("error"))
    throw std::runtime_error(std::string(what) + ": " +
                             (answered ? reply["error"].get<std::string>() : describeEnd(outcome)));
  return reply;
}

/// A process that did not come to its answer.
MethodAnswer
brokenAnswer(const ChildOutcome& outcome, const RunSettings& settings)
{
  MethodAnswer answer;
  answer.message = describeEnd(outcome);
  answer.seconds = outcome.seconds;
  answer.cpu_seconds = outcome.cpu_seconds;
  answer.peak_rss_mib = outcome.peak_rss_mib;
  answer.stopped = outcome.end == ChildOutcome::End::Stopped;
  switch (outcome.end) {
  case ChildOutcome::End::TimedOut:
    answer.status = "timeout";
    answer.message = "no answer within " + Json(settings.timeout).dump() + " s";
    break;
  case ChildOutcome::End::CpuTimedOut:
    answer.status = "timeout";
    answer.message = "no answer within " + Json(settings.cpu_timeout).dump() + " s of processor time";
    break;
  case ChildOutcome::End::NotStarted:
    answer.status = "missing";
    break;
  case ChildOutcome::End::Signalled:
    answer.status = "crashed";
    answer.asked_to_end = outcome.code == SIGTERM || outcome.code == SIGINT || outcome.code == SIGHUP;
    break;
  default:
    answer.status = "failed";
  }
  return answer;
}

std::optional<double>
optionalNumber(const Json& json, const char* key)
{
  if (!json.contains(key) || !json[key].is_number())
    return std::nullopt;
  return json[key].get<double>();
}

// ---------------------------------------------------------------------------------------------------------------------
// The side that answers

/// Answers go to the standard output that the program was started with; what libraries print goes to the errors.
class Reply {
public:
  Reply() : descriptor_(dup(STDOUT_FILENO)) { dup2(STDERR_FILENO, STDOUT_FILENO); }

  void
  send(const Json& json) const
  {
    const std::string line = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    std::size_t sent = 0;
    while (sent < line.size()) {
      const ssize_t got = write(descriptor_, line.data() + sent, line.size() - sent);
      if (got <= 0)
        return; // nobody listens
      sent += static_cast<std::size_t>(got);
    }
  }

private:
  int descriptor_;
};

double
ownCpuSeconds()
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// The truth of a pair. \param[in] rmse false: the pose and the numbers of points alone
Json
truthJson(PairInput pair, bool rmse)
{
  const std::optional<Eigen::Isometry3d> T_target_source = pair.T_target_source;
  if (!rmse)
    pair.T_target_source.reset();
  PairTruth truth = measureTruth(pair);
  truth.T_target_source = T_target_source;
  return toJson(truth);
}

/// The truth of a pair, or why it cannot be measured.
Json
answerTruth(const PairInput& pair, bool rmse)
{
  Json json{{"event", "truth"}};
  try {
    json["truth"] = truthJson(pair, rmse);
  }
  catch (const std::exception& error) {
    json["error"] = error.what();
  }
  return json;
}

/// The stage at which ssfr lost the truth of a pair, or why it is not known; empty where the answer is right.
Json
answerLost(const PairInput& pair, const Result& result, const Options& options, const SuccessBound& bound)
{
  Json json{{"event", "lost"}, {"stage", ""}};
  const bool is_right = pair.T_target_source && !result.candidates.empty() &&
                        isWithin(poseError(result.T_target_source, *pair.T_target_source, pair.reference), bound);
  try {
    if (!is_right)
      json["stage"] = findLostStage(pair, options, bound);
  }
  catch (const std::exception& error) {
    json["error"] = error.what();
  }
  return json;
}

Json
answerMethod(const Json& request, const Reply& reply)
{
  const auto name = request.at("method").get<std::string>();
  const PairRequest pair_request = pairRequestFromJson(request.at("pair"));
  MethodSettings settings;
  applyParameters(request.at("parameters"), settings.rule);
  settings.seed = pair_request.seed;
  Options options = name == "ssfr_paper2017" ? settings.rule.paper2017 : Options();
  const Method* method = findMethod(name);
  if (method && isSsfr(*method) && name != "ssfr_paper2017")
    options = settings.rule.ssfr;
  options.threads = request.at("threads").get<unsigned>();
  if (!pair_request.sensor_at_origin)
    options.viewpoint_mode = ViewpointMode::Unknown;
  const PairInput pair = loadPair(pair_request);
  if (method)
    loadModuleOf(*method);
  reply.send({{"event", "started"}});
  const double cpu = ownCpuSeconds();
  const MethodRun run = runMethod(name, pair.source, pair.target, options, std::nullopt, settings);
  Json json{{"event", "done"}};
  json["cpu_s"] = ownCpuSeconds() - cpu;
  json["peak_rss_mib"] = peakMemoryMib();
  json["status"] = toString(run.result.status);
  json["converged"] = run.result.accepted();
  json["message"] = run.result.message;
  if (!run.result.candidates.empty() || run.result.accepted())
    json["T_target_source"] = matrixJson(run.result.T_target_source);
  json["overlap"] = numberOrNull(run.result.overlap);
  json["confidence"] = run.judged ? numberOrNull(run.result.confidence) : Json(nullptr);
  json["time_s"] = run.seconds;
  json["candidates"] = Json::array();
  for (const CandidateAnswer& candidate : candidatesOf(run.result))
    json["candidates"].push_back(toJson(candidate));
  reply.send(json);
  if (method && method->kind == MethodKind::Ssfr && options.profile == Profile::Default) {
    const Json& bound = request.at("bound");
    reply.send(answerLost(pair, run.result, options, {bound.at(0).get<double>(), bound.at(1).get<double>()}));
  }
  if (request.at("with_truth").get<bool>())
    return answerTruth(pair, request.at("rmse").get<bool>());
  return {{"event", "end"}};
}

/// A cloud as a binary PCD file: x y z, and intensity and normals where it has them.
void
writeCloud(const std::string& path, const io::LoadedCloud& cloud)
{
  pcl::PCLPointCloud2 table;
  const bool large = !cloud.offset.isZero();
  for (const char* name : {"x", "y", "z"})
    io::addField(table, name, large ? pcl::PCLPointField::FLOAT64 : pcl::PCLPointField::FLOAT32);
  if (cloud.has_intensity)
    io::addField(table, "intensity", pcl::PCLPointField::FLOAT32);
  if (cloud.has_normals)
    for (const char* name : {"normal_x", "normal_y", "normal_z"})
      io::addField(table, name, pcl::PCLPointField::FLOAT32);
  io::resizeTable(table, cloud.points->size());
  for (std::size_t i = 0; i < cloud.points->size(); ++i) {
    const auto& point = (*cloud.points)[i];
    std::vector<double> values;
    values.reserve(table.fields.size());
    for (int axis = 0; axis < 3; ++axis)
      values.push_back(cloud.offset[axis] + static_cast<double>(point.data[axis]));
    if (cloud.has_intensity)
      values.push_back(static_cast<double>(point.intensity));
    if (cloud.has_normals)
      for (int axis = 0; axis < 3; ++axis)
        values.push_back(static_cast<double>(point.data_n[axis]));
    std::uint8_t* at = table.data.data() + i * table.point_step;
    for (std::size_t k = 0; k < values.size(); ++k)
      io::storeValue(at + table.fields[k].offset, table.fields[k].datatype, values[k]);
  }
  const Eigen::Vector3d sensor = cloud.viewpoint.value_or(Eigen::Vector3d::Zero());
  io::writePcd(path, table, Eigen::Isometry3d(Eigen::Translation3d(sensor)));
}

void
onSignal(int signal)
{
  stop_requested = signal;
}

/// What is read of the last line of a program that is a JSON object; null: there is none. The rest may be of any
/// length.
Json
readResult(const std::string& output)
{
  const Json line = lastObject(output);
  if (!line.is_object())
    return {};
  Json result = Json::object();
  for (const char* key : {kPoseKeys[0], kPoseKeys[1], "time_s", "overlap", "confidence", "converged", "message"})
    if (line.contains(key))
      result[key] = line[key];
  if (result.contains("message") && result["message"].is_string())
    result["message"] = utf8Prefix(result["message"].get_ref<const std::string&>(), kLongestText);
  return result;
}

/// Watch an external program: its time, its memory, and that nothing of it stays behind.
Json
answerExternal(const Json& request, const Reply& reply)
{
  std::signal(SIGTERM, onSignal);
  adoptStrays();
  ChildRequest child;
  child.command = request.at("words").get<std::vector<std::string>>();
  child.time_limit = request.at("timeout").get<double>();
  child.cpu_limit = request.at("cpu_timeout").get<double>();
  child.threads = request.at("threads").get<unsigned>();
  reply.send({{"event", "started"}});
  const ChildOutcome outcome = runChild(child, stop_requested);
  killStrays();
  return {{"event", "done"},
          {"end", static_cast<int>(outcome.end)},
          {"code", outcome.code},
          {"result", readResult(outcome.output)},
          {"last_line", lastLine(outcome.output)},
          {"errors", outcome.errors},
          {"seconds", outcome.seconds},
          {"cpu_s", outcome.cpu_seconds},
          {"peak_rss_mib", outcome.peak_rss_mib}};
}

Json
answer(const Json& request, const Reply& reply)
{
  const auto kind = request.at("kind").get<std::string>();
  if (kind == "method")
    return answerMethod(request, reply);
  if (kind == "external")
    return answerExternal(request, reply);
  const PairInput pair = loadPair(pairRequestFromJson(request.at("pair")));
  reply.send({{"event", "started"}});
  Json json{{"event", "done"}};
  if (kind == "truth") {
    json["truth"] = truthJson(pair, request.at("rmse").get<bool>());
  }
  else {
    writeCloud(request.at("source").get<std::string>(), pair.source);
    writeCloud(request.at("target").get<std::string>(), pair.target);
  }
  return json;
}

} // namespace

std::vector<std::string>
splitWords(const std::string& command)
{
  std::vector<std::string> words;
  std::string word;
  bool inside = false; // a word has begun
  char quote = 0;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const char c = command[i];
    if (c == '\\' && quote != '\'' && i + 1 < command.size()) {
      word += command[++i];
      inside = true;
    }
    else if (quote != 0) {
      if (c == quote)
        quote = 0;
      else
        word += c;
    }
    else if (c == '"' || c == '\'') {
      quote = c;
      inside = true;
    }
    else if (c == ' ' || c == '\t' || c == '\n') {
      if (inside)
        words.push_back(word);
      word.clear();
      inside = false;
    }
    else {
      word += c;
      inside = true;
    }
  }
  if (quote != 0)
    throw std::invalid_argument(std::string("the quote ") + quote + " is not closed");
  if (inside)
    words.push_back(word);
  return words;
}

PairTruth
askTruth(const PairRequest& request, const RunSettings& settings, const std::atomic<int>& stop)
{
  const Json json{{"kind", "truth"}, {"pair", toJson(request)}, {"rmse", settings.rmse}};
  return pairTruthFromJson(askSurely(json, "the pair cannot be measured", stop).at("truth"));
}

void
askExport(const PairRequest& request,
          const std::string& source,
          const std::string& target,
          const std::atomic<int>& stop)
{
  askSurely({{"kind", "export"}, {"pair", toJson(request)}, {"source", source}, {"target", target}},
            "the pair cannot be written",
            stop);
}

MethodAnswer
askMethod(const std::string& method,
          const PairRequest& request,
          const RunSettings& settings,
          const SuccessBound& bound,
          bool with_truth,
          const std::atomic<int>& stop)
{
  const Json json{{"kind", "method"},
                  {"method", method},
                  {"pair", toJson(request)},
                  {"threads", settings.threads},
                  {"parameters", toJson(settings.rule)},
                  {"bound", {bound.rotation_deg, bound.translation_m}},
                  {"with_truth", with_truth},
                  {"rmse", settings.rmse}};
  const ChildOutcome outcome = askWorker(json, settings.timeout, settings.cpu_timeout, settings.threads, stop);
  const Json reply = lastObject(outcome.output, "done");
  // Once the answer is there, only the measurements that follow can still go wrong.
  if (!reply.is_object() || outcome.end == ChildOutcome::End::Stopped)
    return brokenAnswer(outcome, settings);
  MethodAnswer answer;
  const Json lost = lastObject(outcome.output, "lost");
  if (lost.is_object())
    answer.lost_at = lost.value("stage", "");
  const Json truth = lastObject(outcome.output, "truth");
  if (truth.is_object() && truth.contains("truth"))
    answer.truth = pairTruthFromJson(truth["truth"]);
  answer.cpu_seconds = reply.value("cpu_s", outcome.cpu_seconds);
  answer.peak_rss_mib = reply.value("peak_rss_mib", outcome.peak_rss_mib);
  answer.seconds = reply.value("time_s", outcome.seconds);
  if (reply.contains("error")) {
    answer.status = reply.value("status", "failed");
    answer.message = reply.value("error", "");
    return answer;
  }
  answer.status = reply.value("status", "failed");
  answer.message = reply.value("message", "");
  answer.converged = reply.value("converged", false);
  answer.overlap = optionalNumber(reply, "overlap");
  answer.confidence = optionalNumber(reply, "confidence");
  if (reply.contains("T_target_source"))
    answer.T_target_source = poseFromJson(reply["T_target_source"]);
  for (const Json& candidate : reply.at("candidates"))
    answer.candidates.push_back(candidateFromJson(candidate));
  return answer;
}

MethodAnswer
askExternal(const BenchmarkMethod& method,
            const std::string& source,
            const std::string& target,
            std::uint64_t seed,
            const RunSettings& settings,
            const std::atomic<int>& stop)
{
  std::vector<std::string> words = method.words;
  const std::pair<std::string, std::string> fillings[] = {{"{source}", source},
                                                          {"{target}", target},
                                                          {"{threads}", std::to_string(settings.threads)},
                                                          {"{seed}", std::to_string(seed % 1000000007U)}};
  for (std::string& word : words)
    for (const auto& [name, value] : fillings)
      for (std::size_t at = word.find(name); at != std::string::npos; at = word.find(name, at + value.size()))
        word.replace(at, name.size(), value);
  const Json json{{"kind", "external"},
                  {"words", words},
                  {"timeout", settings.timeout},
                  {"cpu_timeout", settings.cpu_timeout},
                  {"threads", settings.threads}};
  const ChildOutcome watcher = askWorker(json, settings.timeout + kWatcherMargin, 0, settings.threads, stop);
  const Json reply = lastObject(watcher.output);
  if (!reply.is_object() || watcher.end != ChildOutcome::End::Exited || reply.value("event", "") != "done" ||
      reply.contains("error"))
    return brokenAnswer(watcher, settings);
  ChildOutcome outcome;
  outcome.end = static_cast<ChildOutcome::End>(reply.at("end").get<int>());
  outcome.code = reply.at("code").get<int>();
  outcome.errors = reply.at("errors").get<std::string>();
  outcome.seconds = reply.at("seconds").get<double>();
  outcome.cpu_seconds = reply.at("cpu_s").get<double>();
  outcome.peak_rss_mib = reply.at("peak_rss_mib").get<double>();

  MethodAnswer answer = brokenAnswer(outcome, settings);
  if (outcome.end == ChildOutcome::End::NotStarted)
    answer.message = io::inQuotes(words.empty() ? "" : words.front()) + " " + answer.message;
  if (outcome.end != ChildOutcome::End::Exited)
    return answer;
  const Json& result = reply.at("result");
  const char* key = result.contains(kPoseKeys[0]) ? kPoseKeys[0] : kPoseKeys[1];
  if (outcome.code != 0 && !result.contains(key))
    return answer;
  answer.status = "bad_output";
  if (!result.contains(key)) {
    const auto said = reply.at("last_line").get<std::string>();
    answer.message = "no JSON line with T or T_target_source on its standard output" +
                     (said.empty() ? std::string() : "; the last line is " + io::inQuotes(said));
    return answer;
  }
  try {
    answer.T_target_source = poseFromJson(result[key]);
  }
  catch (const std::invalid_argument& error) {
    answer.message = std::string(key) + " " + error.what();
    return answer;
  }
  answer.seconds = optionalNumber(result, "time_s").value_or(outcome.seconds);
  answer.overlap = optionalNumber(result, "overlap");
  answer.confidence = optionalNumber(result, "confidence");
  answer.converged = !result.contains("converged") || result["converged"] == true;
  answer.converged = answer.converged && outcome.code == 0;
  answer.status = answer.converged ? "converged" : "no_candidate";
  answer.message = result.contains("message") && result["message"].is_string() ? result["message"].get<std::string>()
                                                                               : std::string();
  return answer;
}

int
runWorker()
{
  const Reply reply;
  Json json{{"event", "done"}};
  try {
    const std::string text{std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()};
    json = answer(Json::from_cbor(text), reply);
  }
  catch (const std::bad_alloc&) {
    json["status"] = "out_of_memory";
    json["error"] = "out of memory";
  }
  catch (const std::exception& error) {
    json["status"] = "failed";
    json["error"] = error.what();
  }
  reply.send({{"event", "answer"}}); // a failed request too has begun
  reply.send(json);
  // PCL's and OpenMP's destructors could still crash: the answer is given, nothing is left to do.
  _exit(0);
}

} // namespace apps
} // namespace pcl_ssfr
