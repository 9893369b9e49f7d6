#include "server/http/tokens.h"

#include <gtest/gtest.h>

namespace qray::server {
namespace {

std::string line(const std::string& name, const std::string& scope, const std::string& token) {
  return name + " " + scope + " " + sha256(token).hex() + "\n";
}

TEST(Tokens, AreFoundByTheirDigest) {
  const Result<Tokens> tokens =
      Tokens::parse("# who\n\n" + line("a", "read", "one") + line("b", "submit,read", "two") +
                        "  c\tadmin " + sha256("three").hex() + "  # a comment\n",
                    "f");
  ASSERT_TRUE(tokens.ok()) << tokens.error().text();
  EXPECT_EQ(tokens.value().find("one")->scope, Scope::kRead);
  EXPECT_EQ(tokens.value().find("two")->scope, Scope::kSubmit);
  EXPECT_EQ(tokens.value().find("three")->scope, Scope::kAdmin);
  for (const std::string& wrong : {std::string(), std::string("One"), std::string("one "),
                                   sha256("one").hex(), std::string(100'000, 'x')})
    EXPECT_FALSE(tokens.value().find(wrong)) << wrong.substr(0, 80);
}

TEST(Tokens, AWrongLineIsNamed) {
  const std::string good = line("a", "read", "one");
  for (const std::string& wrong :
       {std::string("a read"), std::string("a read 1234"), line("a", "all", "x"),
        line("a", "", "x"), line("a/b", "read", "x"), line("a", "read", "x").substr(0, 60),
        "a read " + std::string(64, 'G'), good.substr(0, good.size() - 1) + " more"}) {
    const Result<Tokens> tokens = Tokens::parse(good + wrong, "f");
    ASSERT_FALSE(tokens.ok()) << wrong;
    EXPECT_EQ(tokens.error().where, "f:2") << wrong;
  }
  EXPECT_FALSE(Tokens::parse("# nobody\n", "f").ok());
  EXPECT_FALSE(Tokens::read("/nowhere/tokens").ok());
}

TEST(Tokens, TheCommandsTokenIsTheOneOfItsLine) {
  const auto run = [](std::vector<const char*> args, std::string& out, std::string& err) {
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const auto code = token_command(static_cast<int>(args.size()), args.data());
    out = ::testing::internal::GetCapturedStdout();
    err = ::testing::internal::GetCapturedStderr();
    return code;
  };
  std::string out, err, other;
  ASSERT_EQ(run({"qrayd", "token", "alice", "submit"}, out, err), 0);
  const Result<Tokens> tokens = Tokens::parse(out, "f");
  ASSERT_TRUE(tokens.ok()) << out;
  const std::string token = err.substr(err.rfind(' ') + 1, 64);
  EXPECT_EQ(tokens.value().find(token)->scope, Scope::kSubmit);
  EXPECT_EQ(out.find(token), std::string::npos);
  run({"qrayd", "token", "alice", "submit"}, other, err);
  EXPECT_NE(out, other);
  EXPECT_EQ(run({"qrayd", "token", "alice"}, out, err), 1);
  EXPECT_EQ(run({"qrayd", "token", "a b", "read"}, out, err), 1);
  EXPECT_EQ(run({"qrayd", "token", "alice", "all"}, out, err), 1);
  EXPECT_FALSE(run({"qrayd", "--port", "0"}, out, err));
}

}  // namespace
}  // namespace qray::server
