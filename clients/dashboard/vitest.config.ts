import { defineConfig } from "vitest/config";

export default defineConfig({
  server: { host: "127.0.0.1" }, // a bare Debian has no file that says where localhost is
  test: { include: ["src/**/*.test.ts"], environment: "node", setupFiles: ["src/node_globals.ts"] },
});
