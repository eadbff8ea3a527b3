// What tests of the dashboard are written with: a running photond, and a real browser that looks at it.
//
//   const daemon = await startDaemon();            // stopped when the file's tests are over
//   test("what holds", async () => {
//     const page = await openPage(daemon, "/jobs");  // closed with the test; every complaint of the browser fails it
//     await until(async () => assert.equal(await page.locator("li").count(), 2));  // what a page comes to
//     await shoot(page, "jobs-empty");               // a picture to look at, in both themes, where $PHOTOND_SCREENSHOTS says
//     await axeClean(page);                          // WCAG A and AA, in both themes
//   });

export * from "./browser.mjs";
export * from "./daemon.mjs";
export * from "./suite.mjs";
