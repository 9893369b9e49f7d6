// Who may call what: a bearer token, or the cookie of a session that one opened (a page's event
// streams and pictures cannot send tokens). POST and DELETE /v1/session. Any thread.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "proto/messages.h"
#include "server/http/router.h"
#include "server/http/tokens.h"

namespace qray::server {

class Access {
 public:
  using Names = std::optional<std::vector<std::string>>;
  // Without tokens everybody may do everything who calls the server by one of these names, or by a
  // loopback address: a page of another site may rebind its own name to the server's address. None:
  // by any.
  Access(Tokens tokens, Names names, std::function<int64_t()> now_ms)
      : tokens_(std::make_shared<const Tokens>(std::move(tokens))),
        names_(std::move(names)),
        now_ms_(std::move(now_ms)) {}
  void add_to(Router& router);
  // From now on. Sessions that were opened by a token that is gone, or means something else, end.
  void replace(Tokens tokens);

  // 421: called by a name that is not served. 401: no token, or an unknown one; 403: its scope does
  // not suffice; none: go on.
  std::optional<proto::Problem> judge(const httplib::Request& req, Scope needed) const;
  // Whose token it has, itself or by a session; empty: none.
  std::string user(const httplib::Request& req) const;

 private:
  struct Caller {
    Scope scope;
    std::string user;  // the token's name
  };
  struct Session {
    Caller caller;
    Digest token;  // that opened it
    int64_t ends_ms;
  };
  void open(const httplib::Request& req, httplib::Response& res);
  void close(const httplib::Request& req, httplib::Response& res);
  std::optional<Caller> caller_of(const httplib::Request& req) const;
  std::string start_session(const Tokens::Entry& token);  // its secret
  std::shared_ptr<const Tokens> tokens() const;

  bool served(const httplib::Request& req) const;

  mutable std::mutex mutex_;  // of tokens_ and sessions_
  std::shared_ptr<const Tokens> tokens_;
  const Names names_;
  const std::function<int64_t()> now_ms_;
  std::map<Digest, Session> sessions_;  // by the digest of their secret; bounded for each user
};

}  // namespace qray::server
