// Where missions come from: out of the page itself, or from the server that the page came from.

import { Mission } from "./mission.js";
import { fromBase64, readPackets, unzip } from "./packets.js";

/** Missions in the order in which they are shown: `{mission, live}`; `live`: where news come from, or null. */
export async function loadMissions() {
  const inside = document.querySelectorAll('script[type="application/x-mission"]');
  if (inside.length) {
    return Promise.all([...inside].map(async (script) => ({
      mission: await missionFrom(fromBase64(script.textContent.trim())),
      live: null,
    })));
  }
  const runs = await (await ask("runs.json")).json();
  return Promise.all(runs.map(async ({ data, live }) => ({
    mission: await missionFrom(new Uint8Array(await (await ask(data)).arrayBuffer())),
    live,
  })));
}

async function ask(where) {
  const answer = await fetch(where);
  if (!answer.ok) throw new Error(`the server says ${answer.status}: ${(await answer.text()).slice(0, 300)}`);
  return answer;
}

async function missionFrom(bytes) {
  const [first, ...blocks] = readPackets(await unzip(bytes));
  const mission = new Mission(first);
  for (const block of blocks) mission.append(block);
  return mission;
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
    stream.addEventListener("block", (event) => {
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
