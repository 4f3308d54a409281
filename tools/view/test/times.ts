// node times.js PAGE TOOL FOLDER: how long the page takes, for bench/README.md. Prints a table; nothing here passes or fails.
import { statSync } from "node:fs";
import type { Page } from "playwright-core";
import { ask, go, hash_of, launch, make, open_page, page_path } from "./browser";

const share = (times: number[], of: number) => times.sort((a, b) => a - b)[Math.min(times.length - 1, Math.floor(of * times.length))]!;

/// Milliseconds of each of 300 moves in the worker and on the page, after 30 to warm.
async function moves(page: Page): Promise<string> {
    const worker: number[] = [], main: number[] = [], layers = await ask<number>(page, "state.slabs.length / 2");
    for (let i = 0; i < 330; ++i) {
        await go(page, (i * 7919 + 1) % layers);
        await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
        const [cut, draw] = await ask<[number, number]>(page, "[state.layer.ms, state.draw_ms]");
        i >= 30 && (worker.push(cut), main.push(draw));
    }
    const of = (times: number[]) => `${share(times, 0.5).toFixed(1)}, ${share(times, 0.95).toFixed(1)}`;
    return `worker ${of(worker)}; page ${of(main)} (ms: p50, p95 of 300 moves)`;
}

const browser = await launch();
console.log(`page: ${statSync(page_path).size} bytes; Chromium ${browser.version()}`);
const page = await open_page(browser);
await page.evaluate(() => {
    Object.assign(globalThis, { longest: 0 });
    new PerformanceObserver((list) => list.getEntries().forEach(({ duration }) => Object.assign(globalThis, { longest: Math.max(duration, (globalThis as never as { longest: number }).longest) }))).observe({ entryTypes: ["longtask"] });
});
await page.keyboard.press("v"); // the layer alone
const begin = Date.now();
await page.setInputFiles("#file", make("bone", 1_000_000, "million.stl"));
await page.waitForSelector("body[data-layer]");
const first = Date.now() - begin;
await hash_of(page);
console.log(`1 M triangles: first layer after ${first} ms, all ${await ask(page, "state.slabs.length / 2")} after ${Date.now() - begin} ms`);
await page.waitForFunction(() => (globalThis as never as { lamella: { state: { islands_upto: number; slabs: ArrayLike<number> } } }).lamella.state.islands_upto * 2 >= (globalThis as never as { lamella: { state: { slabs: ArrayLike<number> } } }).lamella.state.slabs.length, null, { timeout: 60_000 });
console.log(`non-zero: ${await moves(page)}`);
await page.selectOption("#rule", "0");
await page.waitForTimeout(8000);
console.log(`contours: ${await moves(page)}`);
const again = Date.now();
await page.evaluate(() => Object.assign(globalThis, { longest: 0 }));
await page.fill("#height", "0.03");
await page.waitForFunction(() => (globalThis as never as { lamella: { state: { slabs: ArrayLike<number> } } }).lamella.state.slabs.length > 8000);
const planned = Date.now() - again;
await hash_of(page);
console.log(`${await ask(page, "state.slabs.length / 2")} layers: planned after ${planned} ms, all after ${Date.now() - again} ms, longest task ${await page.evaluate("longest")} ms`);
await browser.close();
