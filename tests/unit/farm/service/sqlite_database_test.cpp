// SPDX-License-Identifier: Apache-2.0
// Tests that prepared statements are kept. They must start from the beginning, wherever their last use ended.
#include "host/farm/service/ledger/sqlite_database.h"

#include <gtest/gtest.h>

#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

TEST(SqliteDatabaseTest, AStatementThatWasLeftHalfReadBeginsAnew) {
  const testing::TemporaryFolder folder;
  SqliteDatabase database(folder / "a.sqlite");
  database.execute("CREATE TABLE numbers (number INTEGER); INSERT INTO numbers VALUES (1), (2), (3)");
  const char* const sql = "SELECT number FROM numbers WHERE number >= ? ORDER BY number";
  for (const std::int64_t least : {1, 2}) {
    SqliteStatement& query = database.statement(sql).bind(1, least);
    ASSERT_TRUE(query.step());
    EXPECT_EQ(query.integer(0), least);
  }
  database.statement(sql);
}

}  // namespace
}  // namespace multum
