// Rows of a data folder's database, multiplied while no server uses it.
import { execFileSync } from 'node:child_process';
import { join } from 'node:path';

export const sql = (data, text) =>
  execFileSync('sqlite3', ['-bail', join(data, 'qray.sqlite'), text], { encoding: 'utf8' }).trim();

// `count` rows more of the table's first one, whatever its columns are.
export function multiply(data, table, key, count) {
  const columns = sql(data, `SELECT name FROM pragma_table_info('${table}')`).split('\n')
    .filter((name) => name !== key);
  // A column of its own value in each row would be refused, not doubled.
  const list = columns.map((name) => `"${name}"`).join(',');
  sql(data, `WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < ${count})
    INSERT INTO ${table}(${list}) SELECT ${list} FROM n, (SELECT * FROM ${table} ORDER BY ${key}
    LIMIT 1)`);
}
