// SPDX-License-Identifier: Apache-2.0
// Tests that documents are made from committed sources, or otherwise say that they are not.
#include "tools/lab/bench/documents/committed_tree.h"

#include <gtest/gtest.h>

#include "host/foundation/base/error.h"

namespace multum::bench {
namespace {

TEST(CommittedTreeTest, ACommitIsNamed) {
  EXPECT_EQ(stated_commit("a.json", "9eb764f", false), "commit 9eb764f");
  EXPECT_EQ(stated_commit("a.json", "9eb764f", true), "commit 9eb764f") << "a committed tree needs no permission";
}

TEST(CommittedTreeTest, OtherSourcesAreRefusedWithWhatToDo) {
  for (const char* commit : {"9eb764f-dirty", "unknown"}) {
    try {
      stated_commit("a.json", commit, false);
      ADD_FAILURE() << commit << " was taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      for (const char* part : {"a.json", commit, "--allow-dirty"})
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  }
}

TEST(CommittedTreeTest, WhatIsAllowedIsStated) {
  const std::string text = stated_commit("a.json", "9eb764f-dirty", true);
  EXPECT_NE(text.find("9eb764f-dirty"), std::string::npos) << text;
  EXPECT_NE(text.find("--allow-dirty"), std::string::npos) << text;
}

}  // namespace
}  // namespace multum::bench
