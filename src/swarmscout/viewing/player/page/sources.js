// Where missions come from: out of the page itself, or from the server that the page came from.

import { MapHistory } from "./history.js";
import { Mission } from "./mission.js";
import { fromBase64, readPackets, unzip } from "./packets.js";

/**
 * Missions in the order in which they are shown: `{mission, live, askBelief}`.
 *
 * `live`: where new steps come from, or null; `askBelief(robot, first)`: bytes of a robot's own map from a step on, or
 * null where it is missing.
 */
export async function loadMissions() {
  const inside = document.querySelectorAll('script[type="application/x-mission"]');
  if (inside.length) {
    return Promise.all([...inside].map(async (script, k) => ({
      mission: await missionFrom(fromBase64(script.textContent.trim())),
      live: null,
      askBelief: async (robot) => {
        const kind = `script[type="application/x-belief"][data-mission="${k}"][data-robot="${robot}"]`;
        const kept = document.querySelector(kind);
        return kept && fromBase64(kept.textContent.trim());
      },
    })));
  }
  const runs = await (await ask("runs.json")).json();
  return Promise.all(runs.map(async ({ data, live, belief }) => ({
    mission: await missionFrom(new Uint8Array(await (await ask(data)).arrayBuffer())),
    live,
    askBelief: async (robot, first) => {
      const answer = await ask(`${belief}?robot=${robot}&from=${first}`);
      return new Uint8Array(await answer.arrayBuffer());
    },
  })));
}

async function ask(where) {
  const answer = await fetch(where);
  if (!answer.ok) throw new Error(`the server says ${answer.status}: ${(await answer.text()).slice(0, 300)}`);
  return answer;
}

async function missionFrom(bytes) {
  const [first, ...ranges] = readPackets(await unzip(bytes));
  const mission = new Mission(first);
  for (const range of ranges) mission.append(range);
  return mission;
}

/**
 * Bring a robot's own map up to the last step that is here.
 *
 * Returns whether it is there; what came before stays if there is no more.
 */
export async function takeBelief(mission, askBelief, robot) {
  const known = mission.beliefs.get(robot) ?? new MapHistory(mission.facts, robot);
  if (known.steps < mission.steps) {
    const bytes = await askBelief(robot, known.steps);
    if (!bytes) return false;
    for (const { facts, arrays } of readPackets(await unzip(bytes))) known.append(facts, arrays);
    mission.beliefs.set(robot, known);
  }
  return true;
}

/**
 * Take in a running mission's steps as they come.
 *
 * The server is asked for what follows on the last step that is here, and asked again after a broken
 * connection, so nothing is lost and nothing comes twice.
 */
export function listen(live, mission, onSteps, onState) {
  const connect = () => {
    const stream = new EventSource(`${live}?from=${mission.steps}`);
    stream.addEventListener("open", () => onState("live"));
    stream.addEventListener("steps", (event) => {
      let added = false;
      for (const packet of readPackets(fromBase64(event.data).buffer)) added = mission.append(packet) || added;
      if (added) onSteps();
    });
    stream.addEventListener("end", (event) => {
      stream.close();
      Object.assign(mission.facts, JSON.parse(event.data));
      onState("finished");
    });
    stream.addEventListener("error", () => {
      stream.close();
      onState("waiting");
      setTimeout(connect, 1500);
    });
  };
  connect();
}
