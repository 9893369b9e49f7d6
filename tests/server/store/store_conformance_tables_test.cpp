// What any index of tables and any store of webhooks must do.
#include "tests/server/store/store_conformance.h"

namespace qray::server {
namespace {

using test::kStores;
using enum JobState;

class StoreConformanceTables : public test::StoreTest {};

TableRow table_row(char digit, uint8_t scene = 0, uint64_t samples_seen = 8) {
  TableRow row;
  row.info.id = std::string(32, digit);
  row.info.scene = "box";
  row.info.method = "huang";
  row.info.parents = {"p", "q"};
  row.info.created_ms = 5;
  row.info.bytes = 6;
  row.info.states = 7;
  row.info.samples_seen = samples_seen;
  row.info.job = "j000001";
  row.scene.geometry.bytes[0] = scene;
  return row;
}

TEST_P(StoreConformanceTables, ATableIsRecordedWithTheMoveThatMadeIt) {
  const JobId id = insert();
  JobStore::Change change;
  change.table = table_row('a');
  EXPECT_FALSE(store_->move(id, kSucceeded, change).ok());
  EXPECT_EQ(open_->tables().find(std::string(32, 'a')).error().code, ErrorCode::kNotFound);
  move(id, {kPreparing, kRendering, kFinalizing});
  ASSERT_TRUE(store_->move(id, kSucceeded, change).ok());
  open();
  const Result<proto::TableInfo> found = open_->tables().find(std::string(32, 'a'));
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found.value().parents, (std::vector<std::string>{"p", "q"}));
  EXPECT_EQ(found.value().samples_seen, 8u);
}

TEST_P(StoreConformanceTables, TablesAreFoundBySceneAndByAge) {
  TableIndex& tables = open_->tables();
  for (const TableRow& row :
       {table_row('a'), table_row('b', 1), table_row('c', 0, 9), table_row('d')})
    ASSERT_TRUE(tables.add(row).ok());
  const std::string a(32, 'a'), b(32, 'b'), c(32, 'c'), d(32, 'd');
  EXPECT_EQ(tables.fitting("huang", table_row('a').scene, 8).value(),
            (std::vector<std::string>{c, d, a}));
  EXPECT_EQ(tables.fitting("huang", table_row('a').scene, 1).value(), std::vector<std::string>{c});
  EXPECT_TRUE(tables.fitting("ppg", table_row('a').scene, 8).value().empty());
  ASSERT_TRUE(tables.add(table_row('a')).ok());  // again: the newest
  EXPECT_EQ(tables.list(1, "").value()[0].id, a);
  EXPECT_EQ(tables.list(8, c).value().size(), 1u);
  EXPECT_EQ(tables.list(8, "none").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(tables.ids().value().size(), 4u);
}

TEST_P(StoreConformanceTables, ATableThatAnOpenJobNamesStays) {
  TableIndex& tables = open_->tables();
  const std::string a(32, 'a');
  ASSERT_TRUE(tables.add(table_row('a')).ok());
  JobRequest request;
  request.set(field::kScene, "box");
  request.set(field::kTable, a);
  const JobId id = insert(request);
  EXPECT_EQ(tables.remove(a).error().code, ErrorCode::kConflict);
  move(id, {kCanceled});
  EXPECT_TRUE(tables.remove(a).ok());
  EXPECT_EQ(tables.remove(a).error().code, ErrorCode::kNotFound);
}

TEST_P(StoreConformanceTables, WebhooksAreToldInOrderAndOneHoldsUpNoOther) {
  const JobId before = insert(), first = insert(), second = insert();
  move(before, {kCanceled});
  const uint64_t a = open_->webhooks().add("http://a/", "s").value().id;
  const uint64_t b = open_->webhooks().add("http://b/", "t").value().id;
  const auto next = [&] {
    const auto due = open_->webhooks().next();
    return due.value().value_or(Delivery());
  };
  move(first, {kPreparing, kRendering});
  EXPECT_EQ(next().id, 0u);
  move(first, {kFinalizing, kSucceeded});
  move(second, {kCanceled});
  open();  // after a restart too
  const Delivery to_a = next();
  EXPECT_EQ(to_a.webhook.id, a);
  EXPECT_EQ(to_a.webhook.secret, "s");
  EXPECT_EQ(to_a.job, first);
  EXPECT_EQ(to_a.created_ms, now_ms_);
  ASSERT_TRUE(open_->webhooks().failed(to_a, 5000).ok());
  for (const JobId job : {first, second}) {
    const Delivery to_b = next();
    EXPECT_EQ(to_b.webhook.id, b);
    EXPECT_EQ(to_b.job, job);
    ASSERT_TRUE(open_->webhooks().delivered(to_b).ok());
  }
  EXPECT_EQ(next().id, 0u);
  EXPECT_EQ(open_->webhooks().list().value()[0].waiting, 2u);
  now_ms_ += 5000;
  EXPECT_EQ(next().id, to_a.id);
  EXPECT_EQ(next().webhook.failures, 1u);
  // The clock is turned back by days: that is no reason to wait for them.
  ASSERT_TRUE(open_->webhooks().failed(to_a, 1000).ok());
  now_ms_ -= 100 * WebhookStore::kLongestDelayMs;
  EXPECT_EQ(next().id, to_a.id);
  ASSERT_TRUE(open_->webhooks().give_up(to_a).ok());
  EXPECT_EQ(next().job, second);
  EXPECT_EQ(next().webhook.failures, 2u);
  ASSERT_TRUE(open_->webhooks().delivered(next()).ok());
  EXPECT_EQ(open_->webhooks().list().value()[0].failures, 0u);

  move(insert(), {kCanceled});
  ASSERT_TRUE(open_->webhooks().remove(a).ok());
  EXPECT_EQ(open_->webhooks().remove(a).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(next().webhook.id, b);
  ASSERT_EQ(open_->webhooks().list().value().size(), 1u);
  for (size_t i = 1; i < WebhookStore::kMost; ++i)
    ASSERT_TRUE(open_->webhooks().add("http://c/", "u").ok());
  EXPECT_EQ(open_->webhooks().add("http://c/", "u").error().code, ErrorCode::kConflict);
}

INSTANTIATE_TEST_SUITE_P(Stores, StoreConformanceTables, ::testing::ValuesIn(kStores),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace qray::server
