// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/project_file.h"

#include <sqlite3.h>

#include <chrono>
#include <cstring>
#include <stdexcept>

namespace pcl_ssfr {

namespace {

constexpr int kFormat = 1;             // of the tables: another one is not read
constexpr int kApplication = 0x53534d; // "SSM": a database of something else is not overwritten
constexpr double kTransaction = 0.5;   // [s] that a kill may cost, at most
constexpr int kBusy = 2000;            // [ms] waited for another program that reads

constexpr const char* kTables = R"(
CREATE TABLE IF NOT EXISTS pairs (
  source_hash INTEGER, target_hash INTEGER, settings TEXT, status INTEGER, message TEXT, confidence REAL,
  probability_of_none REAL, seconds REAL, PRIMARY KEY (source_hash, target_hash)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS hypotheses (
  source_hash INTEGER, target_hash INTEGER, rank INTEGER, probability REAL, score REAL, overlap REAL,
  contradiction REAL, rmse REAL, T_target_source BLOB, information BLOB,
  PRIMARY KEY (source_hash, target_hash, rank)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS scans (
  scan INTEGER PRIMARY KEY, name TEXT, hash INTEGER, points INTEGER, bytes INTEGER, component INTEGER,
  T_map_scan BLOB, covariance BLOB, links INTEGER, reason TEXT);
CREATE TABLE IF NOT EXISTS links (
  source INTEGER, target INTEGER, status TEXT, confidence REAL, overlap REAL, rmse REAL, residual_rotation REAL,
  residual_translation REAL, bridge INTEGER, reason TEXT, T_target_source BLOB, PRIMARY KEY (source, target))
  WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS decisions (kind TEXT, value TEXT);
)";

double
now()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Doubles as they are in memory, column after column.
template <typename Matrix>
void
bind(sqlite3_stmt* statement, int index, const Matrix& m)
{
  sqlite3_bind_blob(
      statement, index, m.data(), static_cast<int>(m.size() * static_cast<int>(sizeof(double))), SQLITE_TRANSIENT);
}

void
bind(sqlite3_stmt* statement, int index, const std::string& text)
{
  sqlite3_bind_text(statement, index, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
}

/// False when the blob has another size.
template <typename Matrix>
bool
read(sqlite3_stmt* statement, int column, Matrix& m)
{
  const auto bytes = static_cast<std::size_t>(m.size()) * sizeof(double);
  if (static_cast<std::size_t>(sqlite3_column_bytes(statement, column)) != bytes)
    return false;
  std::memcpy(m.data(), sqlite3_column_blob(statement, column), bytes);
  return true;
}

std::string
text(sqlite3_stmt* statement, int column)
{
  const auto* begin = static_cast<const char*>(sqlite3_column_blob(statement, column));
  return begin ? std::string(begin, static_cast<std::size_t>(sqlite3_column_bytes(statement, column))) : "";
}

std::int64_t
asInteger(std::uint64_t hash)
{
  std::int64_t value = 0;
  std::memcpy(&value, &hash, sizeof(value));
  return value;
}

} // namespace

bool
ProjectFile::holdsLinks(const std::string& path)
{
  sqlite3* database = nullptr;
  sqlite3_stmt* statement = nullptr;
  const bool holds_none =
      sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READWRITE, nullptr) == SQLITE_OK &&
      sqlite3_prepare_v2(database, "SELECT 1 FROM pairs LIMIT 1", -1, &statement, nullptr) == SQLITE_OK &&
      sqlite3_step(statement) == SQLITE_DONE;
  sqlite3_finalize(statement);
  sqlite3_close(database);
  return !holds_none;
}

ProjectFile::ProjectFile(const std::string& path, bool resume) : path_(path)
{
  try {
    if (sqlite3_open(path.c_str(), &database_) != SQLITE_OK)
      fail();
    sqlite3_busy_timeout(database_, kBusy);
    const auto pragma = [&](const char* sql) {
      sqlite3_stmt* statement = prepare(sql);
      const int code = sqlite3_step(statement);
      if (code != SQLITE_ROW && code != SQLITE_DONE)
        fail();
      const int value = code == SQLITE_ROW ? sqlite3_column_int(statement, 0) : 0;
      sqlite3_reset(statement);
      return value;
    };
    const int application = pragma("PRAGMA application_id");
    const int format = pragma("PRAGMA user_version");
    const bool is_new = application == 0 && pragma("SELECT count(*) FROM sqlite_master") == 0;
    if (!is_new && (application != kApplication || format != kFormat))
      throw std::runtime_error(path + ": is no map project of this version");
    pragma("PRAGMA journal_mode=WAL");
    execute("PRAGMA synchronous=NORMAL");
    execute("BEGIN IMMEDIATE");
    execute(kTables);
    execute(("PRAGMA application_id=" + std::to_string(kApplication)).c_str());
    execute(("PRAGMA user_version=" + std::to_string(kFormat)).c_str());
    if (!resume)
      execute("DELETE FROM pairs; DELETE FROM hypotheses;");
    execute("COMMIT");
    insert_link_ = prepare("INSERT OR REPLACE INTO pairs VALUES (?,?,?,?,?,?,?,?)");
    insert_hypothesis_ = prepare("INSERT OR REPLACE INTO hypotheses VALUES (?,?,?,?,?,?,?,?,?,?)");
  }
  catch (...) {
    for (sqlite3_stmt* statement : statements_)
      sqlite3_finalize(statement);
    sqlite3_close(database_);
    throw;
  }
}

ProjectFile::~ProjectFile()
{
  if (in_transaction_)
    sqlite3_exec(database_, "COMMIT", nullptr, nullptr, nullptr);
  for (sqlite3_stmt* statement : statements_)
    sqlite3_finalize(statement);
  sqlite3_close(database_);
}

std::optional<PairLink>
ProjectFile::readLink(std::uint64_t source_hash, std::uint64_t target_hash, const std::string& settings)
{
  sqlite3_stmt* row = prepare("SELECT status, message, confidence, probability_of_none, seconds FROM pairs "
                              "WHERE source_hash = ? AND target_hash = ? AND settings = ?");
  sqlite3_bind_int64(row, 1, asInteger(source_hash));
  sqlite3_bind_int64(row, 2, asInteger(target_hash));
  bind(row, 3, settings);
  int code = sqlite3_step(row);
  std::optional<PairLink> link;
  if (code == SQLITE_ROW) {
    link.emplace();
    link->status = static_cast<Status>(sqlite3_column_int(row, 0));
    link->message = text(row, 1);
    link->confidence = sqlite3_column_double(row, 2);
    link->probability_of_none = sqlite3_column_double(row, 3);
    link->seconds = sqlite3_column_double(row, 4);
    code = SQLITE_DONE;
  }
  sqlite3_reset(row);
  if (code != SQLITE_DONE)
    fail();
  if (!link)
    return link;
  sqlite3_stmt* poses =
      prepare("SELECT probability, score, overlap, contradiction, rmse, T_target_source, information FROM hypotheses "
              "WHERE source_hash = ? AND target_hash = ? ORDER BY rank");
  sqlite3_bind_int64(poses, 1, asInteger(source_hash));
  sqlite3_bind_int64(poses, 2, asInteger(target_hash));
  while ((code = sqlite3_step(poses)) == SQLITE_ROW) {
    PairHypothesis h;
    int column = 0;
    for (double* value : {&h.probability, &h.score, &h.overlap, &h.contradiction, &h.rmse})
      *value = sqlite3_column_double(poses, column++);
    if (!read(poses, 5, h.T_target_source.matrix()) || !read(poses, 6, h.information))
      throw std::runtime_error(path_ + ": a pose in the table hypotheses has another size");
    link->hypotheses.push_back(h);
  }
  sqlite3_reset(poses);
  if (code != SQLITE_DONE)
    fail();
  return link;
}

void
ProjectFile::writeLink(const PairLink& link,
                       std::uint64_t source_hash,
                       std::uint64_t target_hash,
                       const std::string& settings)
{
  writeAtOnce([&] { insert(link, source_hash, target_hash, settings); });
  if (now() - began_ > kTransaction)
    flush();
}

/// Write in the transaction that is open, or a new one. What fails half way is taken back, with all that was written
/// since the transaction began: links that a later run finds again.
void
ProjectFile::writeAtOnce(const std::function<void()>& write)
{
  if (!in_transaction_) {
    execute("BEGIN IMMEDIATE");
    in_transaction_ = true;
    began_ = now();
  }
  try {
    write();
  }
  catch (...) {
    in_transaction_ = false;
    sqlite3_exec(database_, "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

void
ProjectFile::insert(const PairLink& link,
                    std::uint64_t source_hash,
                    std::uint64_t target_hash,
                    const std::string& settings)
{
  // Poses of an earlier link of the pair must not stay behind.
  sqlite3_stmt* remove = prepare("DELETE FROM hypotheses WHERE source_hash = ? AND target_hash = ?");
  sqlite3_bind_int64(remove, 1, asInteger(source_hash));
  sqlite3_bind_int64(remove, 2, asInteger(target_hash));
  step(remove);
  sqlite3_bind_int64(insert_link_, 1, asInteger(source_hash));
  sqlite3_bind_int64(insert_link_, 2, asInteger(target_hash));
  bind(insert_link_, 3, settings);
  sqlite3_bind_int(insert_link_, 4, static_cast<int>(link.status));
  bind(insert_link_, 5, link.message);
  sqlite3_bind_double(insert_link_, 6, link.confidence);
  sqlite3_bind_double(insert_link_, 7, link.probability_of_none);
  sqlite3_bind_double(insert_link_, 8, link.seconds);
  step(insert_link_);
  for (std::size_t rank = 0; rank < link.hypotheses.size(); ++rank) {
    const PairHypothesis& h = link.hypotheses[rank];
    sqlite3_bind_int64(insert_hypothesis_, 1, asInteger(source_hash));
    sqlite3_bind_int64(insert_hypothesis_, 2, asInteger(target_hash));
    sqlite3_bind_int(insert_hypothesis_, 3, static_cast<int>(rank));
    int column = 4;
    for (const double value : {h.probability, h.score, h.overlap, h.contradiction, h.rmse})
      sqlite3_bind_double(insert_hypothesis_, column++, value);
    bind(insert_hypothesis_, 9, h.T_target_source.matrix());
    bind(insert_hypothesis_, 10, h.information);
    step(insert_hypothesis_);
  }
}

void
ProjectFile::flush()
{
  if (!in_transaction_)
    return;
  in_transaction_ = false;
  execute("COMMIT");
}

void
ProjectFile::writeMap(const MultiwayMap& map, const std::vector<std::pair<std::string, std::string>>& decisions)
{
  flush();
  writeAtOnce([&] { insert(map, decisions); });
  flush();
}

void
ProjectFile::insert(const MultiwayMap& map, const std::vector<std::pair<std::string, std::string>>& decisions)
{
  execute("DELETE FROM scans; DELETE FROM links; DELETE FROM decisions;");
  sqlite3_stmt* scan = prepare("INSERT INTO scans VALUES (?,?,?,?,?,?,?,?,?,?)");
  for (std::size_t i = 0; i < map.scans.size(); ++i) {
    const MapScan& s = map.scans[i];
    sqlite3_bind_int64(scan, 1, static_cast<sqlite3_int64>(i));
    bind(scan, 2, s.name);
    sqlite3_bind_int64(scan, 3, asInteger(s.hash));
    sqlite3_bind_int64(scan, 4, static_cast<sqlite3_int64>(s.points));
    sqlite3_bind_int64(scan, 5, static_cast<sqlite3_int64>(s.bytes));
    sqlite3_bind_int(scan, 6, s.component);
    bind(scan, 7, s.T_map_scan.matrix());
    bind(scan, 8, s.covariance);
    sqlite3_bind_int(scan, 9, s.links);
    bind(scan, 10, s.reason);
    step(scan);
  }
  sqlite3_stmt* link = prepare("INSERT INTO links VALUES (?,?,?,?,?,?,?,?,?,?,?)");
  for (const MapLink& l : map.links) {
    sqlite3_bind_int(link, 1, l.source);
    sqlite3_bind_int(link, 2, l.target);
    bind(link, 3, std::string(toString(l.status)));
    int column = 4;
    for (const double value : {l.confidence, l.overlap, l.rmse, l.residual_rotation, l.residual_translation})
      sqlite3_bind_double(link, column++, value);
    sqlite3_bind_int(link, 9, l.bridge ? 1 : 0);
    bind(link, 10, l.reason);
    bind(link, 11, l.T_target_source.matrix());
    step(link);
  }
  sqlite3_stmt* decision = prepare("INSERT INTO decisions VALUES (?,?)");
  for (const auto& [kind, value] : decisions) {
    bind(decision, 1, kind);
    bind(decision, 2, value);
    step(decision);
  }
}

void
ProjectFile::execute(const char* sql)
{
  if (sqlite3_exec(database_, sql, nullptr, nullptr, nullptr) != SQLITE_OK)
    fail();
}

/// A statement, kept for its next use.
sqlite3_stmt*
ProjectFile::prepare(const char* sql)
{
  for (sqlite3_stmt* statement : statements_)
    if (std::strcmp(sqlite3_sql(statement), sql) == 0) {
      sqlite3_reset(statement);
      return statement;
    }
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database_, sql, -1, &statement, nullptr) != SQLITE_OK)
    fail();
  statements_.push_back(statement);
  return statement;
}

void
ProjectFile::step(sqlite3_stmt* statement)
{
  const int code = sqlite3_step(statement);
  sqlite3_reset(statement);
  if (code != SQLITE_DONE)
    fail();
}

void
ProjectFile::fail() const
{
  throw std::runtime_error(path_ + ": " + (database_ ? sqlite3_errmsg(database_) : "cannot be opened"));
}

} // namespace pcl_ssfr
