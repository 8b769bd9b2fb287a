"""`exoid rivals` in a campaign: optimisers on one fit."""

from exoid.apps.campaign.verb import CampaignVerb

VERB = CampaignVerb()
