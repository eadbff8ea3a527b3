// Writes the built dashboard down as a C++ source: node embed.mjs FOLDER SOURCE_FILE
// Each file is there as it is and compressed, so that the daemon sends bytes and computes nothing.

import { createHash } from "node:crypto";
import { readdirSync, readFileSync, renameSync, writeFileSync } from "node:fs";
import { extname, join, relative } from "node:path";
import { gzipSync } from "node:zlib";

const [folder, sourceFile] = process.argv.slice(2);
const mediaTypes = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".css": "text/css; charset=utf-8",
  ".svg": "image/svg+xml",
  ".jpg": "image/jpeg",
};

const files = readdirSync(folder, { recursive: true, withFileTypes: true })
  .filter((entry) => entry.isFile())
  .map((entry) => join(entry.parentPath ?? entry.path, entry.name))
  .sort();

/** Bytes as a C++ string literal. An octal escape has at most three digits, so that no digit after it can join it. */
function literal(bytes) {
  const lines = [];
  for (let at = 0; at < bytes.length; at += 4096) {
    let line = "";
    for (const byte of bytes.subarray(at, at + 4096))
      line +=
        byte >= 0x20 && byte < 0x7f && byte !== 0x22 && byte !== 0x5c && byte !== 0x3f // no ", \ or trigraph's ?
          ? String.fromCharCode(byte)
          : `\\${byte.toString(8).padStart(3, "0")}`;
    lines.push(`"${line}"`);
  }
  return `{${lines.join("\n") || '""'}, ${bytes.length}}`;
}

const entries = files.map((path) => {
  const bytes = readFileSync(path);
  const mediaType = mediaTypes[extname(path)];
  if (!mediaType) throw new Error(`${path}: the daemon has no media type for it`);
  const etag = createHash("sha256").update(bytes).digest("hex");
  return `    {"/${relative(folder, path)}", "${mediaType}", "${etag}",\n${literal(bytes)},\n${literal(gzipSync(bytes, { level: 9 }))}},\n`;
});

const source = `// Written by the build (clients/dashboard/embed.mjs).

#include "server/routes/dashboard.h"

namespace photond::http {

std::span<const DashboardFile> dashboard_files() {
    static constexpr DashboardFile kFiles[] = {
${entries.join("")}    };
    return kFiles;
}

}  // namespace photond::http
`;
writeFileSync(`${sourceFile}.part`, source);
renameSync(`${sourceFile}.part`, sourceFile);
