// proto/openapi.yaml as the judge of what a server answered: the call and its status must be
// listed, and JSON must follow its schema (valijson; draft 7 has all that the contract uses).
// Any thread.
#pragma once

#include <map>
#include <memory>
#include <string>

namespace qray::test {

struct Answer {
  std::string method, target;  // "/v1/jobs?limit=1"
  int status = 0;
  std::string content_type, body;
};

class Contract {
 public:
  // The source tree's, read once.
  static const Contract& instance();

  // What is not as the contract says; empty: nothing.
  std::string fault(const Answer& answer) const;
  // Every "GET /v1/jobs/{}", and its x-scope; empty: it says none.
  std::map<std::string, std::string> calls() const;

 private:
  Contract();
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

// "/v1/jobs/{id}/tiles" -> "/v1/jobs/{}/tiles": the name says nothing.
std::string without_names(const std::string& pattern);

}  // namespace qray::test
