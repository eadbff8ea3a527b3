import { defineConfig } from "vite";

// `npm run dev` shows the dashboard of a daemon that runs already: PHOTOND_URL=http://127.0.0.1:8080 npm run dev
const daemon = process.env.PHOTOND_URL ?? "http://127.0.0.1:8080";
// The daemon takes writes from its own pages only: what the proxy hands on says it comes from there.
const toDaemon = { target: daemon, changeOrigin: true, headers: { origin: daemon } };

export default defineConfig({
  build: {
    target: "es2022",
    modulePreload: { polyfill: false }, // which would be an inline script, and the page's policy allows none
    assetsInlineLimit: 0,
    minify: "terser", // a thirtieth smaller than esbuild makes it
    terserOptions: { compress: { passes: 3, unsafe_arrows: true }, format: { comments: false } },
    reportCompressedSize: false,
  },
  esbuild: { jsx: "automatic", jsxImportSource: "preact", legalComments: "none" },
  server: { proxy: { "/v1": toDaemon, "/metrics": toDaemon, "/readyz": toDaemon } },
});
