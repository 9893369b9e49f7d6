// A farm as its users have it: processes on one database, killed, stopped, drained.
#include "tests/farm/farm.h"

namespace qray::server {
namespace {

using test::FarmTest;
using test::Json;
using test::Process;

std::string worker_of(const Process& front, const std::string& job) {
  const Json all = front.get("/v1/workers");
  for (const Json& worker : all["workers"])
    for (const Json& id : worker["jobs"])
      if (id == job) return worker["id"];
  return "";
}

TEST_F(FarmTest, AWorkerRunsWhatAFrontAccepts) {
  const auto front = this->front(), other = this->front(), worker = this->worker();
  const Json request = job(32);
  const std::string id = front->submit(request);
  const Json done = front->wait_state(id, "succeeded");
  EXPECT_EQ(done["progress"]["samples"], 32);
  EXPECT_EQ(picture(id), picture_alone(request));
  // Any front answers for it, with the same events under the same ids.
  EXPECT_EQ(other->get("/v1/jobs/" + id)["state"], "succeeded");
  const auto events = [&](const Process& of) {
    test::RawConnection stream(of.port());
    stream.send("GET /v1/events?job=" + id +
                " HTTP/1.1\r\nHost: localhost\r\n"
                "Last-Event-ID: 0\r\n\r\n");
    std::string text = stream.read_until("event: done");
    return text.substr(text.find("id: "));
  };
  const std::string seen = events(*front);
  EXPECT_NE(seen.find("preparing"), std::string::npos);
  EXPECT_EQ(seen, events(*other));
}

TEST_F(FarmTest, OthersAreToldOfACancelAndAPause) {
  const auto front = this->front(), worker = this->worker();
  const std::string long_one = front->submit(job(1'000'000));
  front->wait_state(long_one, "rendering");
  // The picture while it forms, from another process.
  for (int i = 0; i < 400; ++i) {
    const auto answer = httplib::Client("127.0.0.1", front->port())
                            .Get("/v1/jobs/" + long_one + "/image.exr?picture=sampled");
    ASSERT_TRUE(answer);
    if (answer->status == 200) break;
    ASSERT_LT(i, 399);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  httplib::Client client("127.0.0.1", front->port());
  ASSERT_EQ(client.Post("/v1/jobs/" + long_one + "/pause")->status, 202);
  front->wait_state(long_one, "paused");
  ASSERT_EQ(client.Post("/v1/jobs/" + long_one + "/resume")->status, 202);
  front->wait_state(long_one, "rendering");
  ASSERT_EQ(client.Post("/v1/jobs/" + long_one + "/cancel")->status, 202);
  front->wait_state(long_one, "canceled");
}

TEST_F(FarmTest, AKilledWorkersJobGoesOnElsewhereToTheSameBits) {
  const auto front = this->front();
  const auto first = worker("first");
  const Json request = job(2500);
  const std::string id = front->submit(request);
  front->wait_state(id, "rendering");
  std::this_thread::sleep_for(std::chrono::milliseconds(1300));  // until its first state is written
  first->end(SIGKILL);
  const auto second = worker("second");
  front->wait_state(id, "succeeded");
  EXPECT_EQ(picture(id), picture_alone(request));
}

TEST_F(FarmTest, AWorkerThatSleptAndWakesUpWritesNothing) {
  const auto front = this->front(), sleeper = worker("sleeper");
  const Json request = job(5000);
  const std::string id = front->submit(request);
  front->wait_state(id, "rendering");
  std::this_thread::sleep_for(std::chrono::milliseconds(1300));
  sleeper->send(SIGSTOP);
  const auto other = worker("other");
  // From here on it is the other's, whatever the first one does.
  std::string has_it = worker_of(*front, id);
  for (int i = 0; i < 1000 && worker_of(*front, id) == has_it; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const std::string now_has_it = worker_of(*front, id);
  EXPECT_NE(now_has_it, has_it);
  sleeper->send(SIGCONT);
  for (int i = 0; i < 500 && log_text("sleeper").find("any more") == std::string::npos; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_NE(log_text("sleeper").find("is not this process's any more"), std::string::npos);
  front->wait_state(id, "succeeded");
  EXPECT_EQ(picture(id), picture_alone(request));
}

TEST_F(FarmTest, TheDatabaseMayGoAwayAndComeBack) {
  const auto front = this->front(), worker = this->worker();
  const Json request = job(1500);
  const std::string id = front->submit(request), second = front->submit(job(16, 5));
  front->wait_state(id, "rendering");
  postgres_->stop_at_once();
  httplib::Client client("127.0.0.1", front->port());
  client.set_read_timeout(30);
  const auto away = client.Get("/v1/jobs/" + id);
  ASSERT_TRUE(away);
  EXPECT_EQ(away->status, 503) << away->body;
  EXPECT_NE(client.Get("/readyz")->status, 200);
  std::this_thread::sleep_for(std::chrono::seconds(3));  // longer than a lease
  postgres_->start();
  front->wait_state(id, "succeeded");
  front->wait_state(second, "succeeded");
  EXPECT_EQ(picture(id), picture_alone(request));
  EXPECT_EQ(picture(second), picture_alone(job(16, 5)));
}

TEST_F(FarmTest, ADrainedWorkerFinishesWhatItHasAndEnds) {
  const auto front = this->front();
  const auto worker = this->worker();
  const std::string id = front->submit(job(2000));
  front->wait_state(id, "rendering");
  const std::string name = worker_of(*front, id);
  httplib::Client client("127.0.0.1", front->port());
  ASSERT_EQ(client.Post("/v1/workers/" + name + "/drain")->status, 202);
  EXPECT_EQ(client.Post("/v1/workers/nobody/drain")->status, 404);
  const std::string next = front->submit(job(16));
  const int status = worker->wait();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(front->get("/v1/jobs/" + id)["state"], "succeeded");
  EXPECT_EQ(front->get("/v1/jobs/" + next)["state"], "queued");
  const auto after = this->worker();
  front->wait_state(next, "succeeded");
}

TEST_F(FarmTest, AnOrderlyStopGivesItsJobBackAtOnce) {
  const auto front = this->front();
  const auto first = worker("first");
  const Json request = job(2500);
  const std::string id = front->submit(request);
  front->wait_state(id, "rendering");
  first->end(SIGTERM);
  EXPECT_EQ(front->get("/v1/jobs/" + id)["state"], "queued");
  EXPECT_TRUE(front->get("/v1/workers")["workers"].size() == 1) << front->get("/v1/workers");
  const auto second = worker("second");
  front->wait_state(id, "succeeded");
  EXPECT_EQ(picture(id), picture_alone(request));
}

}  // namespace
}  // namespace qray::server
