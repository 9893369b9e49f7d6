// What any store of jobs must do.
#include <random>

#include "tests/server/store/store_conformance.h"

namespace qray::server {
namespace {

using test::kStores;
using enum JobState;
using std::chrono::milliseconds;

class StoreConformance : public test::StoreTest {};

TEST_P(StoreConformance, InsertAndGet) {
  JobRequest request;
  request.set(field::kScene, "box");
  request.set(field::kSeconds, 0.1);
  request.set(field::kSeed, UINT64_MAX);
  request.set("camera/position", Vector3{0.1, 0.2, 0.3});
  const JobRecord job = get(insert(request));
  EXPECT_EQ(job.request, request);
  EXPECT_EQ(job.state, kQueued);
  EXPECT_EQ(job.created_ms, 1000);
  EXPECT_EQ(job.started_ms, std::nullopt);
  EXPECT_EQ(kinds_after(0), std::vector<std::string>{"state"});
  const Result<JobRecord> missing = store_->get({99});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
}

TEST_P(StoreConformance, MovesWriteRecordAndEvents) {
  const JobId id = insert();
  now_ms_ = 2000;
  move(id, {kPreparing});
  EXPECT_EQ(get(id).started_ms, 2000);
  EXPECT_EQ(get(id).attempts, 1);
  move(id, {kRendering, kFinalizing});
  now_ms_ = 3000;
  JobStore::Change change;
  change.events.push_back({0, id.text(), "table", "{}"});
  change.edit = [](JobRecord& job) {
    job.table_out = "t";
    job.stats_json = "{}";
    job.biased = true;
    job.progress = {1, 8, 2.5};
    job.warnings = {"one\nline", "two"};
  };
  ASSERT_TRUE(store_->move(id, kSucceeded, change).ok());
  const JobRecord job = get(id);
  EXPECT_EQ(job.state, kSucceeded);
  EXPECT_EQ(job.ended_ms, 3000);
  EXPECT_EQ(job.table_out, "t");
  EXPECT_EQ(job.progress.seconds, 2.5);
  EXPECT_TRUE(job.biased);
  EXPECT_EQ(job.warnings, (std::vector<std::string>{"one line", "two"}));
  EXPECT_EQ(kinds_after(0), (std::vector<std::string>{"state", "state", "state", "state", "table",
                                                      "state", "done"}));
}

TEST_P(StoreConformance, IllegalMovesChangeNothing) {
  const JobId id = insert();
  const uint64_t newest = events_->newest();
  const Result<JobRecord> moved = store_->move(id, kSucceeded);
  ASSERT_FALSE(moved.ok());
  EXPECT_EQ(moved.error().code, ErrorCode::kConflict);
  EXPECT_EQ(get(id).state, kQueued);
  EXPECT_EQ(events_->newest(), newest);
}

TEST_P(StoreConformance, ListsNewestFirst) {
  for (int i = 0; i < 5; ++i) insert();
  const auto ids = [&](size_t limit, std::optional<JobId> before) {
    std::vector<uint64_t> ids;
    const Result<std::vector<JobRecord>> jobs = store_->list(limit, {before});
    for (const JobRecord& job : jobs.value()) ids.push_back(job.id.value);
    return ids;
  };
  EXPECT_EQ(ids(3, {}), (std::vector<uint64_t>{5, 4, 3}));
  EXPECT_EQ(ids(3, JobId{3}), (std::vector<uint64_t>{2, 1}));
}

TEST_P(StoreConformance, ListsByStateAndLabel) {
  JobRequest request;
  request.set(field::kScene, "box");
  for (const char* project : {"lobby", "hall", "lobby", "l'\"obby"}) {
    request.set(field::kLabels, {{"project", project}, {"kind", "test"}});
    insert(request);
  }
  move({1}, {kCanceled});
  const auto ids = [&](const JobStore::Filter& filter) {
    std::vector<uint64_t> ids;
    const Result<std::vector<JobRecord>> jobs = store_->list(10, filter);
    for (const JobRecord& job : jobs.value()) ids.push_back(job.id.value);
    return ids;
  };
  using Labels = std::vector<std::pair<std::string, std::string>>;
  using Ids = std::vector<uint64_t>;
  const Labels lobby{{"project", "lobby"}};
  EXPECT_EQ(ids({{}, {}, lobby}), (Ids{3, 1}));
  EXPECT_EQ(ids({{}, {}, {{"project", "l'\"obby"}}}), (Ids{4}));
  EXPECT_EQ(ids({{}, {kQueued}, lobby}), (Ids{3}));
  EXPECT_EQ(ids({JobId{4}, {kQueued}, {}}), (Ids{3, 2}));
  EXPECT_TRUE(ids({{}, {}, {{"none", "lobby"}}}).empty());
  // Several states: one of them. Several labels: all of them.
  EXPECT_EQ(ids({{}, {kQueued, kCanceled}, lobby}), (Ids{3, 1}));
  EXPECT_EQ(ids({JobId{4}, {kCanceled, kQueued}, {}}), (Ids{3, 2, 1}));
  EXPECT_EQ(ids({{}, {}, {{"kind", "test"}, {"project", "hall"}}}), (Ids{2}));
  EXPECT_EQ(ids({{}, {kQueued, kSucceeded}, {{"kind", "test"}, {"project", "lobby"}}}), (Ids{3}));
  EXPECT_TRUE(ids({{}, {}, {{"project", "lobby"}, {"project", "hall"}}}).empty());
  EXPECT_EQ(store_->count().value().by_state,
            (std::map<JobState, uint64_t>{{kQueued, 3}, {kCanceled, 1}}));
  // By the table that they used or made, with the others beside it.
  for (const uint64_t id : {2, 3, 4}) {
    JobStore::Change change;
    change.edit = [id](JobRecord& job) {
      if (id <= 3) job.table_in = "t";
      if (id >= 3) job.table_out = "t";
    };
    ASSERT_TRUE(store_->move({id}, kPreparing, change).ok());
    move({id}, {kQueued});
  }
  EXPECT_EQ(ids({{}, {}, {}, "t"}), (Ids{4, 3, 2}));
  EXPECT_EQ(ids({JobId{4}, {kQueued, kSucceeded}, {}, "t"}), (Ids{3, 2}));
  EXPECT_EQ(ids({{}, {kQueued}, lobby, "t"}), (Ids{3}));
  EXPECT_TRUE(ids({{}, {kCanceled}, {}, "t"}).empty());
  EXPECT_TRUE(ids({{}, {}, {}, "u"}).empty());
}

TEST_P(StoreConformance, ListsByTime) {
  JobRequest request;
  request.set(field::kScene, "box");
  for (int i = 1; i <= 6; ++i) {
    now_ms_ = 1000 * i;
    request.set(field::kLabels, {{"odd", i % 2 ? "yes" : "no"}});
    insert(request);
  }
  for (const uint64_t id : {1, 2, 3}) {  // at 7, 8 and 9 s
    now_ms_ = 6000 + 1000 * static_cast<int64_t>(id);
    move({id}, {kCanceled});
  }
  using Ids = std::vector<uint64_t>;
  const auto ids = [&](const JobStore::Times& created, const JobStore::Times& ended,
                       JobStore::Filter filter = {}, size_t limit = 10) {
    filter.created = created;
    filter.ended = ended;
    Ids ids;
    const Result<std::vector<JobRecord>> jobs = store_->list(limit, filter);
    for (const JobRecord& job : jobs.value()) ids.push_back(job.id.value);
    return ids;
  };
  EXPECT_EQ(ids({3000, {}}, {}), (Ids{6, 5, 4, 3}));
  EXPECT_EQ(ids({{}, 3000}, {}), (Ids{2, 1}));
  EXPECT_EQ(ids({2000, 5000}, {}), (Ids{4, 3, 2}));
  EXPECT_EQ(ids({2000, 5000}, {}, {}, 2), (Ids{4, 3}));
  EXPECT_EQ(ids({2000, 5000}, {}, {JobId{4}}), (Ids{3, 2}));
  EXPECT_EQ(ids({}, {8000, {}}), (Ids{3, 2}));
  EXPECT_EQ(ids({}, {{}, 8000}), (Ids{1}));  // not those that have not ended
  EXPECT_EQ(ids({2000, {}}, {{}, 9000}), (Ids{2}));
  EXPECT_EQ(ids({2000, {}}, {}, {{}, {}, {{"odd", "yes"}}}), (Ids{5, 3}));
  EXPECT_EQ(ids({2000, {}}, {}, {{}, {kCanceled}}), (Ids{3, 2}));
  EXPECT_EQ(ids({2000, {}}, {{}, 9000}, {{}, {kCanceled}, {{"odd", "no"}}}), (Ids{2}));
}

TEST_P(StoreConformance, ListsJobsByWords) {
  JobRequest request;
  request.set(field::kScene, "box");
  insert(request);
  request.set(field::kMethod, "huang");
  insert(request);
  request.set(field::kScene, "up-1f");
  request.set(field::kLabels, {{"project", "Lobby"}, {"odd", "a\"b%"}});
  insert(request);
  using Ids = std::vector<uint64_t>;
  const auto ids = [&](std::vector<JobStore::Word> words, JobStore::Filter filter = {}) {
    filter.words = std::move(words);
    Ids ids;
    const Result<std::vector<JobRecord>> jobs = store_->list(10, filter);
    for (const JobRecord& job : jobs.value()) ids.push_back(job.id.value);
    return ids;
  };
  EXPECT_EQ(ids({{"box"}}), (Ids{2, 1}));
  EXPECT_EQ(ids({{"adaptive"}}), (Ids{1}));
  EXPECT_EQ(ids({{"j000002"}}), (Ids{2}));
  EXPECT_EQ(ids({{"project:lobby"}}), (Ids{3}));
  EXPECT_EQ(ids({{"b%"}}), (Ids{3}));
  EXPECT_EQ(ids({{"huang"}, {"up"}}), (Ids{3}));
  EXPECT_EQ(ids({{"samples"}}), Ids{});  // names of members are not searched
  EXPECT_EQ(ids({{"kitchen", ",none,up-1f,"}}), (Ids{3}));
  EXPECT_EQ(ids({{"kitchen", ",up-1,"}}), Ids{});
  EXPECT_EQ(ids({{"huang"}}, {JobId{3}, {kQueued}}), (Ids{2}));
  EXPECT_EQ(ids({{"huang"}}, {{}, {}, {{"project", "Lobby"}}}), (Ids{3}));
}

// Whatever filters are combined, in a list long enough that it matters which is asked first.
TEST_P(StoreConformance, ListsWhatAllFiltersFind) {
  std::mt19937 random(7);
  const auto choice = [&random](int most) {
    return static_cast<int>(random() % static_cast<uint32_t>(most));
  };
  const auto label = [](const char* name, int value) {
    return std::pair(std::string(name), std::to_string(value));
  };
  for (int i = 0; i < 12; ++i) {
    now_ms_ = 1000 * i;
    std::vector<JobStore::Posted> posted(100);
    for (JobStore::Posted& one : posted) {
      one.request.set(field::kScene, "box");
      one.request.set(field::kLabels, {label("all", 0), label("few", choice(100))});
    }
    for (const auto& inserted : store_->insert(posted, posted.size()))
      if (choice(20) == 0) move(inserted.value().job.id, {kCanceled});
  }
  const std::vector<JobRecord> all = store_->list(10'000, {}).value();
  const auto within = [](std::optional<int64_t> ms, const JobStore::Times& times) {
    return (!times.from || (ms && *ms >= *times.from)) &&
           (!times.before || (ms && *ms < *times.before));
  };
  for (int trial = 0; trial < 100; ++trial) {
    JobStore::Filter filter;
    if (choice(2)) filter.labels.push_back(label("all", choice(8) ? 0 : 1));
    if (choice(3) == 0) filter.labels.push_back(label("few", choice(101)));
    if (choice(3) == 0) filter.states.push_back(choice(2) ? kQueued : kCanceled);
    if (choice(4) == 0) filter.states.push_back(kFailed);
    if (choice(3) == 0) filter.created.from = 1000 * choice(13);
    if (choice(3) == 0) filter.ended.before = 1000 * choice(13);
    if (choice(3) == 0) filter.before = JobId{static_cast<uint64_t>(choice(1300))};
    const size_t limit = static_cast<size_t>(1 + choice(60));
    std::vector<JobId> wanted, found;
    for (const JobRecord& job : all) {
      const Labels& has = job.request.get(field::kLabels);
      const bool fits =
          std::ranges::all_of(filter.labels,
                              [&](const auto& one) {
                                return has.contains(one.first) && has.at(one.first) == one.second;
                              }) &&
          (filter.states.empty() ||
           std::ranges::find(filter.states, job.state) != filter.states.end()) &&
          within(job.created_ms, filter.created) && within(job.ended_ms, filter.ended) &&
          (!filter.before || job.id < *filter.before);
      if (fits && wanted.size() < limit) wanted.push_back(job.id);
    }
    const Result<std::vector<JobRecord>> jobs = store_->list(limit, filter);
    ASSERT_TRUE(jobs.ok()) << jobs.error().text();
    for (const JobRecord& job : jobs.value()) found.push_back(job.id);
    EXPECT_EQ(found, wanted) << "trial " << trial;
  }
}

TEST_P(StoreConformance, WhatWasAskedForIsChangedInAnyState) {
  const JobId queued = insert(), ended = insert();
  move(ended, {kCanceled});
  for (const JobId id : {queued, ended}) {
    const JobRecord before = get(id);
    const Result<JobRecord> changed = store_->update(id, [](JobRequest& request) {
      request.set(field::kLabels, {{"kind", "new"}});
    });
    ASSERT_TRUE(changed.ok());
    open();
    EXPECT_EQ(get(id).request, changed.value().request);
    EXPECT_EQ(get(id).state, before.state);
    EXPECT_EQ(get(id).ended_ms, before.ended_ms);
  }
  EXPECT_EQ(store_->list(10, {{}, {}, {{"kind", "new"}}}).value().size(), 2u);
  EXPECT_EQ(store_->update({99}, [](JobRequest&) {}).error().code, ErrorCode::kNotFound);
}

TEST_P(StoreConformance, AKeyGivesTheSameJobForADay) {
  JobRequest request;
  request.set(field::kScene, "box");
  const JobStore::IdempotencyKey key{"k", "hash"};
  const JobId id = insert(request, key);
  open();  // after a restart too
  EXPECT_EQ(insert(request, key), id);
  const JobStore::Posted other{request, {{"k", "another"}}};
  EXPECT_EQ(store_->insert({&other, 1}, 1)[0].error().code, ErrorCode::kConflict);
  EXPECT_GT(insert(request, {{"K", "hash"}}), id);
  now_ms_ += 24 * 3600 * 1000 + 1;
  EXPECT_GT(insert(request, key), id);
}

TEST_P(StoreConformance, ManyAreInsertedAtOnceAsOneByOne) {
  const auto posted = [](uint64_t seed, const char* key) {
    JobStore::Posted one;
    one.request.set(field::kScene, "box");
    one.request.set(field::kSeed, seed);
    if (*key) one.key = {key, std::to_string(seed)};
    return one;
  };
  const JobId known = insert(posted(1, "a").request, posted(1, "a").key);
  const uint64_t before = events_->newest();
  const std::vector<JobStore::Posted> all = {posted(2, ""),  posted(1, "a"), posted(3, "b"),
                                             posted(3, "b"), posted(4, "b"), posted(5, ""),
                                             posted(6, ""),  posted(1, "a")};
  const auto inserted = store_->insert(all, 3);
  ASSERT_EQ(inserted.size(), all.size());
  for (const size_t i : {0, 2, 5}) EXPECT_TRUE(inserted[i].value().is_new) << i;
  for (const size_t i : {1, 3, 7}) EXPECT_FALSE(inserted[i].value().is_new) << i;
  EXPECT_EQ(inserted[1].value().job.id, known);
  EXPECT_EQ(inserted[3].value().job.id, inserted[2].value().job.id);
  EXPECT_EQ(inserted[7].value().job.id, known);  // known without any room
  EXPECT_EQ(inserted[4].error().code, ErrorCode::kConflict);
  EXPECT_EQ(inserted[6].error().code, ErrorCode::kBusy);
  EXPECT_EQ(get(inserted[5].value().job.id).request.get(field::kSeed), 5u);
  EXPECT_EQ(kinds_after(before), (std::vector<std::string>(3, "state")));
}

TEST_P(StoreConformance, LogsHoldWhatHappenedLast) {
  const JobId id = insert(), other = insert();
  move(id, {kPreparing});
  store_->log(id, "warning", "a stone\nfell");
  const auto lines = store_->log_of(id).value();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0].text, "queued");
  EXPECT_EQ(lines[1].text, "preparing");
  EXPECT_EQ(lines[2].level, "warning");
  for (int i = 0; i < JobStore::kLogLines + 5; ++i) store_->log(id, "info", std::to_string(i));
  const auto last = store_->log_of(id).value();
  EXPECT_EQ(last.size(), static_cast<size_t>(JobStore::kLogLines));
  EXPECT_EQ(last.back().text, std::to_string(JobStore::kLogLines + 4));
  EXPECT_EQ(store_->log_of(other).value().size(), 1u);
}

TEST_P(StoreConformance, OnlyEndedJobsAreForgotten) {
  const JobId open_job = insert(), ended = insert();
  move(ended, {kCanceled});
  EXPECT_EQ(store_->remove(open_job).error().code, ErrorCode::kConflict);
  const uint64_t newest = events_->newest();
  ASSERT_TRUE(store_->remove(ended).ok());
  EXPECT_EQ(store_->get(ended).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store_->remove(ended).error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(store_->log_of(ended).value().empty());
  EXPECT_EQ(kinds_after(newest), std::vector<std::string>{"deleted"});
  EXPECT_GT(insert(), ended);  // its number is not used again
  EXPECT_EQ(store_->ended_before(INT64_MAX, 10).value().size(), 0u);
}

TEST_P(StoreConformance, RestartQueuesWhatWasOpen) {
  const JobId queued = insert(), rendering = insert(), canceling = insert(), ended = insert();
  const JobId pausing = insert(), paused = insert();
  move(pausing, {kPreparing, kPausing});
  move(paused, {kPaused});
  move(rendering, {kPreparing, kLearning, kRendering});
  move(canceling, {kPreparing, kCanceling});
  move(ended, {kPreparing, kRendering, kFinalizing, kSucceeded});
  open();
  EXPECT_EQ(recovered_, (std::vector<JobId>{queued, rendering}));
  EXPECT_EQ(get(rendering).state, kQueued);
  EXPECT_EQ(get(canceling).state, kCanceled);
  EXPECT_EQ(get(pausing).state, kPaused);
  EXPECT_EQ(get(paused).state, kPaused);
  EXPECT_EQ(get(ended).state, kSucceeded);
}

TEST_P(StoreConformance, AJobThatEndsTheServerThreeTimesFails) {
  const JobId id = insert();
  for (int attempt = 1; attempt <= kMaxAttempts; ++attempt) {
    ASSERT_EQ(get(id).state, kQueued) << attempt;
    move(id, {kPreparing, kRendering});
    open();
  }
  EXPECT_TRUE(recovered_.empty());
  EXPECT_EQ(get(id).state, kFailed);
  EXPECT_TRUE(get(id).error.has_value());
}

TEST_P(StoreConformance, AJobThatGetsSomewhereMayBeInterruptedAnyNumberOfTimes) {
  const JobId id = insert();
  for (int attempt = 1; attempt <= 2 * kMaxAttempts; ++attempt) {
    ASSERT_EQ(get(id).state, kQueued) << attempt;
    move(id, {kPreparing, kRendering});
    ASSERT_TRUE(store_->reset_attempts(id).ok());
    open();
  }
}

TEST_P(StoreConformance, EventIdsRiseAcrossRestartsAndReadersGoOn) {
  const JobId id = insert();
  const uint64_t seen = events_->newest();
  move(id, {kCanceled});
  store_->publish_hint({0, id.text(), "progress", "{}"});
  const uint64_t hint = events_->newest();
  open();
  EXPECT_GT(events_->newest(), hint);
  EXPECT_EQ(kinds_after(seen), (std::vector<std::string>{"state", "done"}));
  EXPECT_TRUE(kinds_after(hint).empty());
  EXPECT_FALSE(events_->wait(hint, "", milliseconds(0)).reset);
  insert();
  EXPECT_EQ(kinds_after(hint), std::vector<std::string>{"state"});
}

// A run that was given up for dead, and comes back when another has the job.
TEST_P(StoreConformance, OnlyTheLastClaimMoves) {
  const JobId id = insert();
  move(id, {kPreparing});
  const uint64_t first = get(id).claim;
  open();  // the job is queued again
  move(id, {kPreparing});
  const uint64_t second = get(id).claim;
  EXPECT_GT(second, first);
  JobStore::Change change;
  change.claim = first;
  EXPECT_EQ(store_->move(id, kRendering, change).error().code, ErrorCode::kConflict);
  EXPECT_EQ(get(id).state, kPreparing);
  change.claim = second;
  EXPECT_TRUE(store_->move(id, kRendering, change).ok());
}

TEST_P(StoreConformance, IdsThatWereGivenElsewhereAreNotGivenAgain) {
  insert();
  ASSERT_TRUE(store_->give_no_id_up_to({40}).ok());
  EXPECT_EQ(insert(), JobId{41});
  EXPECT_EQ(store_->ids().value().newest, JobId{41});
  EXPECT_EQ(store_->ids().value().there.size(), 2u);
  EXPECT_TRUE(store_->try_writing().ok());
}

INSTANTIATE_TEST_SUITE_P(Stores, StoreConformance, ::testing::ValuesIn(kStores),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace qray::server
