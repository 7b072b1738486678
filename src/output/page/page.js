// Puts views and plots into the page, and keeps the page of a run under way up to date.
// SPDX-License-Identifier: BSD-3-Clause
import { View } from "bodies";
import { Plots, unpackSeries } from "plots";

const PAUSE = 3000; // ms between two questions to the server
const { runs, live } = JSON.parse(document.getElementById("data").textContent);

async function views() {
  const place = document.getElementById("views"), made = [];
  place.className = runs.length > 1 ? "views several" : "views";
  for (const [k, run] of runs.entries()) {
    const box = place.appendChild(document.createElement("section"));
    const name = box.appendChild(document.createElement("h3")), inside = box.appendChild(document.createElement("div"));
    name.textContent = run.name;
    name.hidden = runs.length === 1;
    try {
      made.push(new View(inside, run, k));
      await made.at(-1).load(run.frames);
    } catch (error) {
      inside.innerHTML = "<p class=note>The bodies cannot be shown: this browser draws no WebGL 2.</p>";
      console.warn(error);
    }
  }
  for (const view of made)
    view.onTurn = (turned) => made.forEach((other) => other !== turned && other.turnLike(turned));
  return made;
}

async function ask(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
  return answer.json();
}

/// Asks what is new while somebody looks.
async function follow(view, plots) {
  const [run] = runs;
  const seen = { rows: run.series.all, words: "" }, sign = document.getElementById("live");
  for (;;) {
    try {
      const state = await ask("state");
      sign.textContent = state.over ? "The run is over." : "Under way: this page keeps itself up to date.";
      if (state.identity !== (seen.identity ??= state.identity)) location.reload();
      if (view && state.shown.some((number) => !view.frames.some((frame) => frame.number === number))) {
        for (const number of state.shown)
          if (!view.frames.some((frame) => frame.number === number)) {
            const frame = await ask(`snapshots/${number}`);
            if (frame) await view.add(frame);
          }
        view.keep(state.shown);
        view.settle();
      }
      if (state.rows !== seen.rows) {
        seen.rows = state.rows;
        Object.assign(run, await ask("series"));
        plots.series = [await unpackSeries(run)];
        plots.renew();
      }
      if (state.words !== seen.words) {
        seen.words = state.words;
        for (const [name, text] of Object.entries(await ask("words"))) document.getElementById(name).innerHTML = text;
      }
    } catch {
      sign.textContent = "The server does not answer: the page stays as it is.";
    }
    await new Promise((resume) => { setTimeout(resume, PAUSE); });
    while (document.hidden) await new Promise((resume) => { setTimeout(resume, 500); });
  }
}

const made = await views();
const plots = new Plots(document.getElementById("plots"), runs, await Promise.all(runs.map(unpackSeries)));
window.spall = { views: made, plots };
document.documentElement.dataset.ready = "yes";
if (live) follow(made[0], plots);
